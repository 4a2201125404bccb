// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/gpu_scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <new>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "core/colour.h"
#include "render/energy_tables.h"
#include "render/shadow_filter.h"

namespace stillray::render {
namespace {

/// Triangles with a vertex coordinate beyond this bound, or NaN, are never hit (Embree's bound).
constexpr float kFarthestVertex = 1.844e18f;

bool Usable(vec3 p) {
  return std::abs(p.x) < kFarthestVertex && std::abs(p.y) < kFarthestVertex &&
         std::abs(p.z) < kFarthestVertex;
}

vec4 Row(const mat4& m, int row) {
  return {m[0][row], m[1][row], m[2][row], m[3][row]};
}

Aabb BoxOf(const BvhTriangle& t) {
  return {glm::min(t.p0, glm::min(t.p1, t.p2)), glm::max(t.p0, glm::max(t.p1, t.p2))};
}

/// Adds the triangles of a mesh whose vertices are `positions`.
void AppendTriangles(const PlacedInstance& placed, const vec3* positions, uint32_t instance,
                     std::vector<BvhTriangle>* out) {
  const std::vector<uint32_t>& indices = placed.mesh->indices;
  const uint32_t see_through = IsSeeThrough(placed) ? 1 : 0;
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    const BvhTriangle t = {positions[indices[i]],     instance,
                           positions[indices[i + 1]], static_cast<uint32_t>(i / 3),
                           positions[indices[i + 2]], see_through};
    if (Usable(t.p0) && Usable(t.p1) && Usable(t.p2)) {
      out->push_back(t);
    }
  }
}

/// Bounds of a transformed box, slightly enlarged to cover the rounding of rays transformed to the
/// box's space.
Aabb PlaceBox(const Aabb& box, const mat4& world) {
  Aabb placed;
  for (int corner = 0; corner < 8; ++corner) {
    const vec4 p((corner & 1) != 0 ? box.max.x : box.min.x,
                 (corner & 2) != 0 ? box.max.y : box.min.y,
                 (corner & 4) != 0 ? box.max.z : box.min.z, 1.0f);
    const vec3 q(world * p);
    placed.min = glm::min(placed.min, q);
    placed.max = glm::max(placed.max, q);
  }
  constexpr float kMargin = 0x1p-20f;
  const vec3 margin = glm::max(glm::abs(placed.min), glm::abs(placed.max)) * kMargin;
  return {placed.min - margin, placed.max + margin};
}

/// The inverse of an affine transform, in double precision; false if there is none.
bool Invert(const mat4& world, mat4* inverse) {
  const glm::dmat4 exact(world);
  const double determinant = glm::determinant(glm::dmat3(exact));
  if (!std::isfinite(determinant) || determinant == 0.0) {
    return false;
  }
  *inverse = mat4(glm::inverse(exact));
  for (int column = 0; column < 4; ++column) {
    const vec4 c = (*inverse)[column];
    if (!Usable(vec3(c))) {
      return false;
    }
  }
  return true;
}

template <typename T>
uint32_t AppendWords(const std::vector<T>& values, std::vector<uint32_t>* words) {
  if (values.empty()) {
    return kNoArray;
  }
  const auto first = static_cast<uint32_t>(words->size());
  words->resize(words->size() + values.size() * sizeof(T) / sizeof(uint32_t));
  std::memcpy(words->data() + first, values.data(), values.size() * sizeof(T));
  return first;
}

GpuTextureRef MakeRef(const TextureRef& ref) {
  const mat3& m = ref.transform;
  return {vec3(m[0][0], m[1][0], m[2][0]), ref.texture, vec3(m[0][1], m[1][1], m[2][1]),
          ref.uv_set};
}

GpuMaterial MakeMaterial(const Material& m) {
  GpuMaterial out = {};
  out.base_colour = m.base_color;
  out.emission = m.emission;
  out.metallic = m.metallic;
  out.roughness = m.roughness;
  out.normal_scale = m.normal_scale;
  out.alpha_cutoff = m.alpha_cutoff;
  out.transmission = m.transmission;
  out.attenuation_colour = m.attenuation_color;
  out.attenuation_distance = m.attenuation_distance;
  out.multiscatter_colour = m.multiscatter_color;
  out.scatter_anisotropy = m.scatter_anisotropy;
  out.ior = m.ior;
  out.alpha_mode = static_cast<uint32_t>(m.alpha_mode);
  out.double_sided = m.double_sided ? 1 : 0;
  out.solid = m.solid ? 1 : 0;
  out.layers = kNoArray;
  out.base_colour_texture = MakeRef(m.base_color_texture);
  out.metallic_roughness_texture = MakeRef(m.metallic_roughness_texture);
  out.normal_texture = MakeRef(m.normal_texture);
  out.emissive_texture = MakeRef(m.emissive_texture);
  out.transmission_texture = MakeRef(m.transmission_texture);
  return out;
}

GpuLayers MakeLayers(const Material& m) {
  GpuLayers out = {};
  out.specular_colour = m.specular_color;
  out.specular = m.specular;
  out.coat = m.clearcoat;
  out.coat_roughness = m.clearcoat_roughness;
  out.coat_normal_scale = m.clearcoat_normal_scale;
  out.sheen_colour = m.sheen_color;
  out.sheen_roughness = m.sheen_roughness;
  out.sheen_colour_texture = MakeRef(m.sheen_color_texture);
  out.sheen_roughness_texture = MakeRef(m.sheen_roughness_texture);
  out.through = m.diffuse_transmission;
  out.through_colour = m.diffuse_transmission_color;
  out.through_texture = MakeRef(m.diffuse_transmission_texture);
  out.through_colour_texture = MakeRef(m.diffuse_transmission_color_texture);
  out.anisotropy = m.anisotropy;
  out.anisotropy_texture = MakeRef(m.anisotropy_texture);
  out.anisotropy_turn = {std::cos(m.anisotropy_rotation), std::sin(m.anisotropy_rotation)};
  out.film = HasFilm(m) ? m.iridescence : 0.0f;
  out.film_ior = m.iridescence_ior;
  out.film_texture = MakeRef(m.iridescence_texture);
  out.film_thickness_texture = MakeRef(m.iridescence_thickness_texture);
  out.film_thickness = {m.iridescence_thickness_min, m.iridescence_thickness_max};
  out.coat_texture = MakeRef(m.clearcoat_texture);
  out.coat_roughness_texture = MakeRef(m.clearcoat_roughness_texture);
  out.coat_normal_texture = MakeRef(m.clearcoat_normal_texture);
  out.specular_texture = MakeRef(m.specular_texture);
  out.specular_colour_texture = MakeRef(m.specular_color_texture);
  return out;
}
static_assert(static_cast<uint32_t>(AlphaMode::kOpaque) == kAlphaOpaque &&
              static_cast<uint32_t>(AlphaMode::kMask) == kAlphaMask &&
              static_cast<uint32_t>(AlphaMode::kBlend) == kAlphaBlend);

uint32_t LookupOf(const Texture& texture) {
  return static_cast<uint32_t>(texture.wrap_u) | static_cast<uint32_t>(texture.wrap_v) << 2 |
         (texture.nearest ? 16u : 0u);
}

void AppendTable(EnergyTable table, std::vector<float>* out) {
  static_assert(EnergyTable::kSize * EnergyTable::kSize == kEnergyTableWords);
  for (int j = 0; j < EnergyTable::kSize; ++j) {
    for (int i = 0; i < EnergyTable::kSize; ++i) {
      out->push_back(table.At(i, j));
    }
  }
}

constexpr size_t kMostWords = std::numeric_limits<uint32_t>::max();

}  // namespace

Status GpuScene::AddMeshes() {
  const Scene& scene = state_.scene();
  struct Arrays {
    uint32_t indices, positions, normals, tangents, uv_0, uv_1, colours;
  };
  std::vector<Arrays> arrays;
  for (const Mesh& mesh : scene.meshes) {
    arrays.push_back({AppendWords(mesh.indices, &words_), AppendWords(mesh.positions, &words_),
                      AppendWords(mesh.normals, &words_), AppendWords(mesh.tangents, &words_),
                      AppendWords(mesh.uv[0], &words_), AppendWords(mesh.uv[1], &words_),
                      AppendWords(mesh.colors, &words_)});
    if (words_.size() >= kMostWords) {
      return Status::Unsupported(
          fmt::format("the meshes up to \"{}\" have {} words, more than 32 bits can number",
                      mesh.name, words_.size()));
    }
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const Arrays& of = arrays[static_cast<size_t>(scene.instances[i].mesh)];
    GpuInstance instance = {};
    instance.material = static_cast<uint32_t>(state_.instances()[i].material_index);
    instance.indices = of.indices;
    instance.positions = of.positions;
    instance.normals = of.normals;
    instance.previous_positions = of.positions;
    instance.previous_normals = of.normals;
    instance.tangents = of.tangents;
    instance.uv_0 = of.uv_0;
    instance.uv_1 = of.uv_1;
    instance.colours = of.colours;
    instances_.push_back(instance);
  }
  return Status::Ok();
}

/// Adds the deformed vertices of instances with a constant pose, and allocates space for the
/// vertices of two moments for all other deforming instances.
Status GpuScene::AddDeformedVertices() {
  const auto add = [&](const void* values, size_t words) {
    const size_t first = words_.size();
    words_.resize(first + words);
    if (values != nullptr) {
      std::memcpy(words_.data() + first, values, words * sizeof(uint32_t));
    }
    return static_cast<uint32_t>(first);
  };
  previous_arrays_.resize(instances_.size());
  for (const bool deforms : {false, true}) {
    first_deforming_word_ = words_.size();
    for (size_t i = 0; i < instances_.size(); ++i) {
      const PlacedInstance& from = state_.instances()[i];
      const Mesh& mesh = *from.mesh;
      if (from.deforms != deforms || from.vertices.positions == mesh.positions.data()) {
        continue;
      }
      const size_t count = mesh.positions.size();
      GpuInstance& to = instances_[i];
      to.positions = add(from.vertices.positions, 3 * count);
      to.normals = add(from.vertices.normals, 3 * count);
      to.previous_positions = to.positions;
      to.previous_normals = to.normals;
      if (from.vertices.tangents != nullptr) {
        to.tangents = add(from.vertices.tangents, 4 * count);
      }
      if (deforms) {
        previous_arrays_[i] = {add(nullptr, 3 * count), add(nullptr, 3 * count)};
      }
      if (words_.size() >= kMostWords) {
        return Status::Unsupported(
            fmt::format("the meshes up to the deformed \"{}\" have {} words, more than 32 bits can "
                        "number",
                        mesh.name, words_.size()));
      }
    }
  }
  deforming_words_ = words_.size() - first_deforming_word_;
  return Status::Ok();
}

void GpuScene::UpdateVertices(size_t i) {
  const PlacedInstance& from = state_.instances()[i];
  GpuInstance& to = instances_[i];
  const size_t count = from.mesh->positions.size();
  const auto copy = [&](uint32_t first, const auto* values) {
    std::memcpy(words_.data() + first, values, count * sizeof(*values));
  };
  copy(to.positions, from.vertices.positions);
  copy(to.normals, from.vertices.normals);
  if (from.vertices.tangents != nullptr) {
    copy(to.tangents, from.vertices.tangents);
  }
  const bool changed = from.HasChangedShape();
  if (changed) {
    copy(previous_arrays_[i][0], from.previous_vertices.positions);
    copy(previous_arrays_[i][1], from.previous_vertices.normals);
  }
  to.previous_positions = changed ? previous_arrays_[i][0] : to.positions;
  to.previous_normals = changed ? previous_arrays_[i][1] : to.normals;
}

/// Updates the triangles of a deforming instance and refits its tree. A rebuilt tree would be
/// better, but takes one thread longer than the duration of a frame.
void GpuScene::UpdateBottom(Bottom* bottom) {
  const PlacedInstance& placed = state_.instance(bottom->instance);
  if (bottom->shape == placed.shape) {
    return;
  }
  bottom->shape = placed.shape;
  const vec3* positions = placed.vertices.positions;
  BvhTriangle* triangles = triangles_.data() + bottom->group.first;
  std::vector<Aabb> boxes(bottom->group.count);
  vec3 anchor(0.0f);
  for (size_t k = 0; k < boxes.size(); ++k) {
    BvhTriangle& t = triangles[k];
    const uint32_t* corner = placed.mesh->indices.data() + 3 * static_cast<size_t>(t.primitive);
    t.p0 = positions[corner[0]];
    t.p1 = positions[corner[1]];
    t.p2 = positions[corner[2]];
    if (Usable(t.p0) && Usable(t.p1) && Usable(t.p2)) {
      anchor = t.p0;
    } else {
      t.p0 = t.p1 = t.p2 = anchor;  // no ray hits a triangle without area
    }
    boxes[k] = BoxOf(t);
  }
  bottom->bounds = RefitBvh({nodes_.data() + bottom->root, bottom->node_count}, bottom->root,
                            bottom->group.first, boxes);
}

void GpuScene::UpdateDeforming() {
  tbb::parallel_for(size_t{0}, instances_.size(), [&](size_t i) {
    if (state_.instances()[i].deforms) {
      UpdateVertices(i);
    }
  });
  tbb::parallel_for(size_t{0}, bottoms_.size(), [&](size_t i) {
    if (bottoms_[i].deforms) {
      UpdateBottom(&bottoms_[i]);
    }
  });
}

Status GpuScene::AddLensMasks() {
  for (const LensMask& mask : lens_masks_.all()) {
    mask_words_.push_back(AppendWords(mask.sums, &words_));
  }
  return words_.size() < kMostWords
             ? Status::Ok()
             : Status::Unsupported("meshes and lens masks have more words than 32 bits can number");
}

uint32_t GpuScene::LensMaskWords(int texture) const {
  const LensMask* mask = lens_masks_.Find(texture);
  return mask == nullptr ? 0 : mask_words_[static_cast<size_t>(mask - lens_masks_.all().data())];
}

void GpuScene::AddEnergies() {
  AppendTable(SpecularEnergyTables().scale, &energies_);
  AppendTable(SpecularEnergyTables().offset, &energies_);
  const std::vector<Material>& all = state_.scene().materials;
  const bool any_sheen = std::any_of(all.begin(), all.end(), HasSheen);
  AppendTable(any_sheen ? SheenEnergyTable().albedo : EnergyTable(), &energies_);
  if (std::any_of(all.begin(), all.end(), [](const Material& m) { return m.anisotropy > 0.0f; })) {
    const AnisotropicEnergy& tables = AnisotropicEnergyTables();
    energies_.insert(energies_.end(), tables.scale().begin(), tables.scale().end());
    energies_.insert(energies_.end(), tables.offset().begin(), tables.offset().end());
  }
  std::map<float, uint32_t> known;
  for (size_t i = 0; i < materials_.size(); ++i) {
    const Material& material = state_.scene().materials[i];
    if (material.transmission <= 0.0f) {
      continue;
    }
    const auto [at, is_new] =
        known.try_emplace(material.ior, static_cast<uint32_t>(energies_.size()));
    if (is_new) {
      const GlassEnergy glass = MakeGlassEnergy(material.ior);
      for (const EnergyTable* table :
           {&glass.enter_reflected, &glass.enter_total, &glass.leave_reflected, &glass.leave_total,
            &glass.sheet_reflected}) {
        AppendTable(*table, &energies_);
      }
    }
    materials_[i].glass_tables = at->second;
  }
}

Status GpuScene::AddMaterials() {
  for (const Material& material : state_.scene().materials) {
    materials_.push_back(MakeMaterial(material));
    if (IsLayered(material)) {
      materials_.back().layers = AppendWords(std::vector<GpuLayers>{MakeLayers(material)}, &words_);
      with_layers_ = true;
    }
    with_media_ = with_media_ || ScattersInside(material);
  }
  for (uint32_t i = 0; i < kSrgbTableSize; ++i) {
    texels_.push_back(std::bit_cast<uint32_t>(SrgbDecode(static_cast<float>(i) / 255.0f)));
  }
  return Status::Ok();
}

void GpuScene::AddAtlas(const TextureAtlas& atlas) {
  texels_.push_back(std::bit_cast<uint32_t>(1.0f / static_cast<float>(atlas.width)));
  texels_.push_back(std::bit_cast<uint32_t>(1.0f / static_cast<float>(atlas.height)));
  for (size_t i = 0; i < atlas.places.size(); ++i) {
    const Texture& texture = state_.scene().textures[i];
    const AtlasPlace& place = atlas.places[i];
    textures_.push_back({place.x | place.y << 16, texture.width, texture.height,
                         LookupOf(texture) | place.layer << kAtlasLayer});
  }
}

Status GpuScene::AddTexels() {
  for (const Texture& texture : state_.scene().textures) {
    textures_.push_back(
        {static_cast<uint32_t>(texels_.size()), texture.width, texture.height, LookupOf(texture)});
    for (size_t k = 0; k + 3 < texture.texels.size(); k += 4) {
      const uint8_t* t = texture.texels.data() + k;
      texels_.push_back(t[0] | uint32_t{t[1]} << 8 | uint32_t{t[2]} << 16 | uint32_t{t[3]} << 24);
    }
    if (texels_.size() >= kMostWords) {
      return Status::Unsupported(
          fmt::format("the textures up to \"{}\" have {} texels, more than 32 bits can number",
                      texture.name, texels_.size()));
    }
  }
  return Status::Ok();
}

Result<GpuScene::Bottom> GpuScene::AddBottom(std::vector<BvhTriangle> triangles,
                                             const std::string& what) {
  std::vector<Aabb> boxes(triangles.size());
  std::transform(triangles.begin(), triangles.end(), boxes.begin(), BoxOf);
  Result<WideBvh> bvh = builder_->Build(boxes, kMostLeafItems, kBottomStack, what);
  if (!bvh.ok()) {
    return bvh.status();
  }
  const auto first_node = static_cast<uint32_t>(nodes_.size());
  const auto first_triangle = static_cast<uint32_t>(triangles_.size());
  if (triangles_.size() + triangles.size() > kLeafFirstMask) {
    return Status::Unsupported(
        fmt::format("{} and what precedes it have {} triangles, at most {} can be numbered", what,
                    triangles_.size() + triangles.size(), kLeafFirstMask));
  }
  for (BvhNode node : bvh->nodes) {
    for (int i = 0; i < 4; ++i) {
      uint32_t& child = node.children[i];
      child += child == 0 ? 0 : ((child & kLeafBit) != 0 ? first_triangle : first_node);
    }
    nodes_.push_back(node);
  }
  TriangleGroup group = {first_triangle, static_cast<uint32_t>(triangles.size()), 0};
  for (const uint32_t item : bvh->order) {
    triangles_.push_back(triangles[item]);
    group.opaque += triangles[item].see_through == 0 ? 1 : 0;
  }
  if (group.count > 0) {
    groups_.push_back(group);
  }
  return Bottom{kNoInstance, first_node,  static_cast<uint32_t>(bvh->nodes.size()),
                group,       bvh->bounds, false};
}

Status GpuScene::AddStatic() {
  std::vector<BvhTriangle> triangles;
  for (size_t i = 0; i < state_.instances().size(); ++i) {
    const PlacedInstance& instance = state_.instances()[i];
    if (!instance.instanced) {
      AppendTriangles(instance, instance.placed, static_cast<uint32_t>(i), &triangles);
    }
  }
  if (triangles.empty()) {
    return Status::Ok();
  }
  Result<Bottom> bottom = AddBottom(std::move(triangles), "what stands still");
  if (bottom.ok()) {
    bottoms_.push_back(*bottom);
  }
  return bottom.status();
}

Status GpuScene::BuildBottomLevels() {
  const Scene& scene = state_.scene();
  // Inner nodes have at least two children, except a root above a single leaf.
  top_nodes_ = scene.instances.size() + 1;
  nodes_.resize(top_nodes_);
  bottoms_.reserve(scene.instances.size() + 1);  // pointers to elements must stay valid
  STILLRAY_RETURN_IF_ERROR(AddStatic());
  STILLRAY_RETURN_IF_ERROR(AddMoving());
  STILLRAY_RETURN_IF_ERROR(AddDeforming());
  placements_.resize(std::max<size_t>(bottoms_.size(), 1));
  return Status::Ok();
}

Status GpuScene::AddMoving() {
  const Scene& scene = state_.scene();
  std::vector<const Bottom*> of_mesh(scene.meshes.size(), nullptr);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const PlacedInstance& instance = state_.instances()[i];
    if (!instance.instanced || instance.deforms || instance.mesh->indices.empty()) {
      continue;
    }
    const Bottom*& known = of_mesh[static_cast<size_t>(scene.instances[i].mesh)];
    if (known == nullptr) {
      std::vector<BvhTriangle> triangles;
      AppendTriangles(instance, instance.mesh->positions.data(), kNoInstance, &triangles);
      const Result<Bottom> made =
          AddBottom(std::move(triangles), fmt::format("mesh \"{}\"", instance.mesh->name));
      if (!made.ok()) {
        return made.status();
      }
      bottoms_.push_back(*made);
      known = &bottoms_.back();
    } else {
      bottoms_.push_back(*known);
    }
    bottoms_.back().instance = static_cast<uint32_t>(i);
  }
  return Status::Ok();
}

/// Builds trees over the rest pose, whose limbs are separated; UpdateBottom refits them at every
/// moment.
Status GpuScene::AddDeforming() {
  first_deforming_group_ = groups_.size();
  first_deforming_node_ = nodes_.size();
  first_deforming_triangle_ = triangles_.size();
  for (size_t i = 0; i < state_.instances().size(); ++i) {
    const PlacedInstance& instance = state_.instances()[i];
    if (!instance.deforms) {
      continue;
    }
    std::vector<BvhTriangle> triangles;
    AppendTriangles(instance, instance.mesh->positions.data(), kNoInstance, &triangles);
    if (triangles.empty()) {
      continue;
    }
    Result<Bottom> made =
        AddBottom(std::move(triangles), fmt::format("mesh \"{}\"", instance.mesh->name));
    STILLRAY_RETURN_IF_ERROR(made.status());
    made->instance = static_cast<uint32_t>(i);
    made->deforms = true;
    bottoms_.push_back(*made);
  }
  return Status::Ok();
}

void GpuScene::PlaceInstances() {
  for (size_t i = 0; i < instances_.size(); ++i) {
    const PlacedInstance& from = state_.instances()[i];
    GpuInstance& to = instances_[i];
    to.world_x = Row(from.world, 0);
    to.world_y = Row(from.world, 1);
    to.world_z = Row(from.world, 2);
    to.previous_x = Row(from.previous_world, 0);
    to.previous_y = Row(from.previous_world, 1);
    to.previous_z = Row(from.previous_world, 2);
    to.orientation = from.orientation;
  }
}

Status GpuScene::Update() {
  PlaceInstances();
  UpdateDeforming();
  std::vector<Aabb> boxes;
  std::vector<Placement> placed;
  for (const Bottom& bottom : bottoms_) {
    if (!Usable(bottom.bounds.min)) {
      continue;  // the mesh has no triangles
    }
    mat4 to_object(1.0f);
    Aabb box = bottom.bounds;
    if (bottom.instance != kNoInstance) {
      const mat4& world = state_.instance(bottom.instance).world;
      if (!Invert(world, &to_object)) {
        continue;  // an animated scale may be zero
      }
      box = PlaceBox(box, world);
      if (!Usable(box.min) || !Usable(box.max)) {
        continue;
      }
    }
    boxes.push_back(box);
    placed.push_back({Row(to_object, 0), Row(to_object, 1), Row(to_object, 2), bottom.root,
                      bottom.instance, bottom.group.first, bottom.group.opaque});
  }
  const Result<WideBvh> top = builder_->Build(boxes, 1, kTopStack, "the instances");
  if (!top.ok()) {
    return top.status();
  }
  std::copy(top->nodes.begin(), top->nodes.end(), nodes_.begin());
  for (size_t i = 0; i < placed.size(); ++i) {
    placements_[i] = placed[top->order[i]];
  }
  placed_count_ = placed.size();
  return Status::Ok();
}

Result<std::unique_ptr<GpuScene>> GpuScene::Create(const SceneState& state,
                                                   const TextureAtlas* atlas) {
  try {
    std::unique_ptr<GpuScene> scene(new GpuScene(state));
    Result<std::unique_ptr<WideBvhBuilder>> builder = WideBvhBuilder::Create();
    if (!builder.ok()) {
      return builder.status();
    }
    scene->builder_ = std::move(*builder);
    STILLRAY_RETURN_IF_ERROR(scene->AddMeshes());
    STILLRAY_RETURN_IF_ERROR(scene->AddDeformedVertices());
    STILLRAY_RETURN_IF_ERROR(scene->AddLensMasks());
    STILLRAY_RETURN_IF_ERROR(scene->AddMaterials());
    if (atlas != nullptr) {
      scene->AddAtlas(*atlas);
    } else {
      STILLRAY_RETURN_IF_ERROR(scene->AddTexels());
    }
    scene->AddEnergies();
    STILLRAY_RETURN_IF_ERROR(scene->BuildBottomLevels());
    STILLRAY_RETURN_IF_ERROR(scene->Update());
    return scene;
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("arranging the scene for the GPU: out of memory");
  }
}

}  // namespace stillray::render
