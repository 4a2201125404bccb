// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/scene_state.h"

#include <algorithm>
#include <utility>

#include <tbb/parallel_for.h>

#include "render/shared.h"
#include "render/texture.h"

namespace stillray::render {
namespace {

void Place(PlacedInstance* instance, const mat4& world) {
  instance->world = world;
  const mat3 linear(world);
  instance->orientation = glm::determinant(linear) < 0.0f ? -1.0f : 1.0f;
  instance->normal_matrix = CofactorMatrix(linear) * instance->orientation;
}

/// Maximum number of triangles copied for repeated meshes: about half a gigabyte.
constexpr size_t kMaxCopiedTriangles = 4'000'000;
/// Smaller meshes take less memory as copies than as instances.
constexpr size_t kMinSharedTriangles = 64;

template <typename T>
T Interpolate(const Mesh& mesh, const Hit& hit, const std::vector<T>& values) {
  const uint32_t* corner = mesh.indices.data() + 3 * static_cast<size_t>(hit.primitive);
  return values[corner[0]] * (1.0f - hit.u - hit.v) + values[corner[1]] * hit.u +
         values[corner[2]] * hit.v;
}

/// Nodes with an animated transform, or with an animated ancestor.
/// \param turns  only nodes with animated rotation or scale
std::vector<bool> AnimatedNodes(const Scene& scene, bool turns) {
  std::vector<bool> animated(scene.nodes.size(), false);
  for (const AnimationChannel& channel : scene.animation) {
    if (channel.property != AnimatedProperty::kWeights &&
        (!turns || channel.property != AnimatedProperty::kTranslation)) {
      animated[static_cast<size_t>(channel.node)] = true;
    }
  }
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const int parent = scene.nodes[i].parent;
    animated[i] = animated[i] || (parent >= 0 && animated[static_cast<size_t>(parent)]);
  }
  return animated;
}

VertexArrays ArraysOf(const std::vector<vec3>& positions, const std::vector<vec3>& normals,
                      const std::vector<vec4>& tangents) {
  return {positions.data(), normals.data(), tangents.empty() ? nullptr : tangents.data()};
}

VertexArrays ArraysOf(const DeformedMesh& mesh) {
  return ArraysOf(mesh.positions, mesh.normals, mesh.tangents);
}

}  // namespace

bool IsLayered(const Material& material) {
  return material.specular != 1.0f || material.specular_texture.texture >= 0 ||
         material.specular_color != vec3(1.0f) || material.specular_color_texture.texture >= 0 ||
         material.clearcoat > 0.0f || HasSheen(material) || material.diffuse_transmission > 0.0f ||
         material.anisotropy > 0.0f || HasFilm(material);
}

bool ScattersInside(const Material& material) {
  return material.solid && std::isfinite(material.attenuation_distance) &&
         dot(material.multiscatter_color, vec3(1.0f) - material.attenuation_color) > 0.0f;
}

bool HasFilm(const Material& material) {
  const bool from_texture = material.iridescence_thickness_texture.texture >= 0;
  return material.iridescence > 0.0f &&
         (material.iridescence_thickness_max > 0.0f ||
          (from_texture && material.iridescence_thickness_min > 0.0f));
}

bool HasSheen(const Material& material) {
  return MaxComponent(material.sheen_color) > 0.0f;
}

SceneState::SceneState(const Scene& scene) : scene_(&scene) {
  const std::vector<bool> animated = AnimatedNodes(scene, false);
  const std::vector<bool> turning = AnimatedNodes(scene, true);
  instances_.resize(scene.instances.size());
  for (size_t i = 0; i < instances_.size(); ++i) {
    PlacedInstance& instance = instances_[i];
    instance.mesh = &scene.meshes[static_cast<size_t>(scene.instances[i].mesh)];
    instance.material_index = instance.mesh->material;
    instance.material = &scene.materials[static_cast<size_t>(instance.material_index)];
    instance.moving = animated[static_cast<size_t>(scene.instances[i].node)];
    instance.may_turn = turning[static_cast<size_t>(scene.instances[i].node)];
    const Instance& from = scene.instances[i];
    if (from.skin >= 0) {
      const std::vector<int>& joints = scene.skins[static_cast<size_t>(from.skin)].joints;
      instance.moving = std::any_of(joints.begin(), joints.end(), [&](int joint) {
        return animated[static_cast<size_t>(joint)];
      });
    }
    instance.deforms = (from.skin >= 0 && instance.moving) || HasAnimatedWeights(scene, from);
    instance.moving = instance.moving || instance.deforms;
    instance.may_turn = (from.skin < 0 && instance.may_turn) || instance.deforms;
    may_turn_ = may_turn_ || instance.may_turn;
    instance.vertices = instance.previous_vertices =
        ArraysOf(instance.mesh->positions, instance.mesh->normals, instance.mesh->tangents);
    if (MayDeform(scene, from)) {
      deformations_.push_back({i, {}, {}});
    }
    instance.instanced = instance.moving;
    instance.opaque = instance.material->alpha_mode == AlphaMode::kOpaque;
    instance.layered = IsLayered(*instance.material);
  }
}

bool SceneState::Update(double seconds, double previous_seconds) {
  nodes_ = NodeTransforms(*scene_, seconds);
  previous_nodes_ = NodeTransforms(*scene_, previous_seconds);
  bool moved = !placed_;
  for (size_t i = 0; i < instances_.size(); ++i) {
    const auto node = static_cast<size_t>(scene_->instances[i].node);
    PlacedInstance& instance = instances_[i];
    const bool skinned = scene_->instances[i].skin >= 0;
    const mat4 world = skinned ? mat4(1.0f) : nodes_[node];
    if (!placed_ || instance.world != world) {
      moved = true;
      Place(&instance, world);
    }
    instance.previous_world = skinned ? mat4(1.0f) : previous_nodes_[node];
  }
  for (Deformation& deformation : deformations_) {
    moved = UpdateDeformation(seconds, previous_seconds, &deformation) || moved;
  }
  if (!placed_) {
    ShareMeshes();
    PlaceStatic();
  }
  placed_ = true;
  return moved;
}

/// Current vertices often become the previous vertices of the next frame: both are cached with
/// their poses.
bool SceneState::UpdateDeformation(double seconds, double previous_seconds,
                                   Deformation* deformation) {
  const Instance& of = scene_->instances[deformation->instance];
  PlacedInstance& instance = instances_[deformation->instance];
  Posed& now = deformation->now;
  Posed& before = deformation->before;
  Pose pose = PoseOf(*scene_, of, nodes_, seconds);
  Pose previous_pose = PoseOf(*scene_, of, previous_nodes_, previous_seconds);
  const auto set = [&](Pose* to, Posed* posed) {
    if (!posed->known || !(posed->pose == *to)) {
      Deform(*instance.mesh, *to, &posed->mesh);
      posed->pose = std::move(*to);
      posed->known = true;
    }
  };
  const bool changed = !now.known || !(now.pose == pose);
  const bool stands = pose == previous_pose;
  if (!stands && changed && now.known && now.pose == previous_pose) {
    std::swap(now, before);
  }
  instance.orientation = of.skin >= 0 ? PoseOrientation(pose) : instance.orientation;
  set(&pose, &now);
  instance.vertices = ArraysOf(now.mesh);
  instance.shape += changed ? 1 : 0;
  if (!stands) {
    set(&previous_pose, &before);
  }
  instance.previous_vertices = stands ? instance.vertices : ArraysOf(before.mesh);
  return changed;
}

std::vector<AccelPlace> SceneState::Places() const {
  std::vector<AccelPlace> places(instances_.size());
  for (size_t i = 0; i < places.size(); ++i) {
    places[i] = {instances_[i].world, instances_[i].vertices.positions, instances_[i].shape};
  }
  return places;
}

/// Copying makes tracing faster, and costs about 120 bytes per triangle. Repeated meshes whose
/// copies would take too much memory are instanced, like moving meshes.
void SceneState::ShareMeshes() {
  std::vector<size_t> places(scene_->meshes.size(), 0);
  for (size_t i = 0; i < instances_.size(); ++i) {
    places[static_cast<size_t>(scene_->instances[i].mesh)] += instances_[i].moving ? 0 : 1;
  }
  size_t copied = 0;
  for (size_t m = 0; m < places.size(); ++m) {
    copied += places[m] > 1 ? (places[m] - 1) * scene_->meshes[m].indices.size() / 3 : 0;
  }
  if (copied <= kMaxCopiedTriangles) {
    return;
  }
  for (size_t i = 0; i < instances_.size(); ++i) {
    PlacedInstance& instance = instances_[i];
    const bool worth_it = !MayDeform(*scene_, scene_->instances[i]) &&
                          places[static_cast<size_t>(scene_->instances[i].mesh)] > 1 &&
                          instance.mesh->indices.size() / 3 >= kMinSharedTriangles;
    instance.instanced = instance.instanced || (worth_it && IsInvertible(instance.world));
  }
}

/// Transforms the vertices of static instances to world space once, for the BVH and for hits.
void SceneState::PlaceStatic() {
  placed_positions_.resize(instances_.size());
  tbb::parallel_for(size_t{0}, instances_.size(), [&](size_t i) {
    PlacedInstance& instance = instances_[i];
    if (instance.instanced) {
      return;
    }
    std::vector<vec3>& placed = placed_positions_[i];
    // Padding: Embree loads four floats at the last vertex.
    placed.resize(instance.mesh->positions.size() + 1);
    for (size_t k = 0; k < instance.mesh->positions.size(); ++k) {
      placed[k] = vec3(instance.world * vec4(instance.vertices.positions[k], 1.0f));
    }
    instance.placed = placed.data();
  });
}

size_t SceneState::memory_bytes() const {
  size_t bytes = instances_.capacity() * sizeof(PlacedInstance);
  for (const std::vector<vec3>& placed : placed_positions_) {
    bytes += placed.capacity() * sizeof(vec3);
  }
  for (const Deformation& deformation : deformations_) {
    for (const Posed* posed : {&deformation.now, &deformation.before}) {
      bytes += (posed->mesh.positions.capacity() + posed->mesh.normals.capacity()) * sizeof(vec3) +
               posed->mesh.tangents.capacity() * sizeof(vec4);
    }
  }
  return bytes;
}

vec2 SceneState::Uv(const Mesh& mesh, const Hit& hit, int set) {
  const std::vector<vec2>& uv = mesh.uv[set];
  return uv.empty() ? vec2(0.0f) : Interpolate(mesh, hit, uv);
}

vec4 SceneState::TextureValue(const TextureRef& ref, const Hit& hit, bool srgb) const {
  if (ref.texture < 0) {
    return vec4(1.0f);
  }
  const vec2 uv = TransformUv(ref, Uv(*instances_[hit.instance].mesh, hit, ref.uv_set));
  return SampleTexture(scene_->textures[static_cast<size_t>(ref.texture)], uv,
                       srgb ? TexelEncoding::kSrgb : TexelEncoding::kLinear);
}

vec4 SceneState::BaseColour(const Hit& hit) const {
  const PlacedInstance& instance = instances_[hit.instance];
  vec4 colour = instance.material->base_color;
  colour *= TextureValue(instance.material->base_color_texture, hit, true);
  if (!instance.mesh->colors.empty()) {
    colour *= Interpolate(*instance.mesh, hit, instance.mesh->colors);
  }
  return glm::clamp(colour, 0.0f, 1.0f);
}

vec3 SceneState::MeanBaseColour(const Hit& hit, const Footprint& footprint, vec2 within) const {
  const PlacedInstance& instance = instances_[hit.instance];
  const ivec2 counts = TapCounts(hit, footprint);
  vec3 sum(0.0f);
  float weight = 0.0f;
  for (int j = 0; j < counts.y && counts != ivec2(1); ++j) {
    for (int i = 0; i < counts.x; ++i) {
      const vec2 place = TapOf(footprint, vec2(hit.u, hit.v), within, i, j, counts);
      if (IsInTriangle(place)) {
        Hit tap = hit;
        tap.u = place.x;
        tap.v = place.y;
        const vec4 colour = BaseColour(tap);
        const float opacity = OpacityOf(instance, colour.w);
        sum += vec3(colour) * opacity;
        weight += opacity;
      }
    }
  }
  return weight > 0.0f ? sum / weight : vec3(BaseColour(hit));
}

/// Texture samples for MeanBaseColour along both axes of the pixel.
ivec2 SceneState::TapCounts(const Hit& hit, const Footprint& footprint) const {
  const PlacedInstance& instance = instances_[hit.instance];
  const TextureRef& ref = instance.material->base_color_texture;
  if (ref.texture < 0 || instance.mesh->uv[ref.uv_set].empty()) {
    return ivec2(1);
  }
  const Texture& texture = scene_->textures[static_cast<size_t>(ref.texture)];
  const vec2 size(texture.width, texture.height);
  const std::vector<vec2>& uv = instance.mesh->uv[ref.uv_set];
  const uint32_t* corner = instance.mesh->indices.data() + 3 * static_cast<size_t>(hit.primitive);
  const auto texels = [&](vec2 along) {
    const vec2 change =
        (uv[corner[1]] - uv[corner[0]]) * along.x + (uv[corner[2]] - uv[corner[0]]) * along.y;
    return vec2(ref.transform * vec3(change, 0.0f)) * size;
  };
  return ivec2(TapsAlong(texels(footprint.right)), TapsAlong(texels(footprint.down)));
}

float SceneState::OpacityOf(const PlacedInstance& instance, float alpha) {
  if (instance.opaque) {
    return 1.0f;
  }
  if (instance.material->alpha_mode == AlphaMode::kMask) {
    return alpha >= instance.material->alpha_cutoff ? 1.0f : 0.0f;
  }
  return alpha;
}

float SceneState::Opacity(const Hit& hit) const {
  const PlacedInstance& instance = instances_[hit.instance];
  return instance.opaque ? 1.0f : OpacityOf(instance, BaseColour(hit).w);
}

vec3 SceneState::Emission(const Hit& hit) const {
  const Material& material = *instances_[hit.instance].material;
  return material.emission * vec3(TextureValue(material.emissive_texture, hit, true));
}

}  // namespace stillray::render
