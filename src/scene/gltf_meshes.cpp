// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "scene/gltf_accessor.h"
#include "scene/gltf_import.h"
#include "scene/gltf_primitive.h"
#include "scene/material_textures.h"
#include "scene/mesh_tools.h"

namespace stillray {

namespace {

constexpr uint64_t kMaxInstances = 10'000'000;
/// Cost of an instance in elements: an instance takes about 900 bytes, mostly in the BVH, an
/// element up to 28.
constexpr uint64_t kElementsPerInstance = 32;
/// Cost of a deformed vertex in elements: it takes about 80 bytes, and its triangles 80 more in the
/// BVH.
constexpr uint64_t kElementsPerDeformedVertex = 4;
constexpr uint64_t kTriangles = 4;
constexpr uint64_t kTriangleStrip = 5;
constexpr uint64_t kTriangleFan = 6;

uint64_t AccessorCount(const JsonView& root, int accessor) {
  return root.Item("accessors", static_cast<size_t>(accessor)).Count("count", 0);
}

/// glTF's default material, added when the first primitive without a material is read.
int DefaultMaterial(GltfImport* import, int* index) {
  if (*index < 0) {
    *index = static_cast<int>(import->scene.materials.size());
    import->scene.materials.emplace_back();
    import->scene.materials.back().name = "default";
  }
  return *index;
}

/// Fills the plan of one primitive; false if it is skipped or after a failure.
bool PlanPrimitive(GltfImport* import, const JsonView& view, Primitive* plan) {
  const JsonView root = import->Root();
  const size_t accessors = root.Size("accessors");
  plan->view = view;
  plan->mode = view.Count("mode", kTriangles);
  if (plan->mode > kTriangleFan) {
    view.Fail("mode", fmt::format("{} is none of glTF's modes", plan->mode));
  } else if (plan->mode < kTriangles) {
    view.Warn("mode", "points and lines are not supported and were left out");
    return false;
  }
  const JsonView attributes = view.Object("attributes");
  const auto find = [&](const char* name) {
    return attributes.Index(name, accessors, "accessors");
  };
  plan->material = view.Index("material", root.Size("materials"), "materials");
  plan->indices = view.Index("indices", accessors, "accessors");
  plan->position = find("POSITION");
  plan->normal = find("NORMAL");
  plan->tangent = find("TANGENT");
  plan->color = find("COLOR_0");
  plan->uv = {find("TEXCOORD_0"), find("TEXCOORD_1")};
  if (!import->log.ok()) {
    return false;
  }
  if (plan->position < 0) {
    // Allowed by glTF for extensions with their own geometry.
    view.Warn("attributes", "has no POSITION, so the primitive was left out");
    return false;
  }
  const uint64_t corners = AccessorCount(root, plan->indices >= 0 ? plan->indices : plan->position);
  uint64_t cost = plan->mode == kTriangles ? corners : 3 * corners;
  for (const int accessor : {plan->indices, plan->position, plan->normal, plan->tangent,
                             plan->color, plan->uv[0], plan->uv[1]}) {
    cost += SparseCount(root, accessor);
  }
  const uint64_t vertices = AccessorCount(root, plan->position);
  return PlanDeformation(root, view, vertices, plan, &cost) && import->log.ok() &&
         import->Charge(view.path(), cost);
}

bool ReadIndices(const GltfDocument& document, Primitive* primitive, size_t vertices,
                 std::vector<uint32_t>* out) {
  if (primitive->indices < 0) {
    out->resize(vertices);
    for (size_t i = 0; i < vertices; ++i) {
      (*out)[i] = static_cast<uint32_t>(i);
    }
    return true;
  }
  Accessor accessor;
  if (!OpenAttribute(document, primitive, primitive->indices, "indices", 1, 1, &accessor)) {
    return false;
  }
  if (!accessor.is_unsigned()) {
    primitive->log.Fail(
        Status::BadData(fmt::format("{}.indices: accessors[{}] does not hold unsigned integers",
                                    primitive->view.path(), primitive->indices)));
    return false;
  }
  out->resize(accessor.count());
  for (size_t i = 0; i < out->size(); ++i) {
    const uint32_t index = accessor.ReadIndex(i);
    if (index >= vertices) {
      primitive->log.Fail(Status::BadData(
          fmt::format("{}.indices: index {} at position {} is out of range, there are {} vertices",
                      primitive->view.path(), index, i, vertices)));
      return false;
    }
    (*out)[i] = index;
  }
  return true;
}

/// Triangles of strips and fans in the order and orientation of glTF 2.0, 3.7.2.1.
void MakeTriangles(Primitive* primitive, std::vector<uint32_t>* indices) {
  if (primitive->mode == kTriangles) {
    if (indices->size() % 3 != 0) {
      primitive->log.Warn(
          fmt::format("{}: {} corners are not a multiple of 3, the rest was left out",
                      primitive->view.path(), indices->size()));
      indices->resize(indices->size() / 3 * 3);
    }
    return;
  }
  std::vector<uint32_t> triangles;
  const std::vector<uint32_t>& p = *indices;
  for (size_t i = 0; i + 2 < p.size(); ++i) {
    if (primitive->mode == kTriangleStrip) {
      triangles.insert(triangles.end(), {p[i], p[i + 1 + i % 2], p[i + 2 - i % 2]});
    } else {
      triangles.insert(triangles.end(), {p[i + 1], p[i + 2], p[0]});
    }
  }
  *indices = std::move(triangles);
}

/// Reads the positions in use and drops triangles that cannot be rendered.
/// \param used  [in,out] file index of every vertex of the mesh
void ReadPositions(const Accessor& accessor, Primitive* primitive, std::vector<uint32_t>* used) {
  Mesh& mesh = primitive->mesh;
  mesh.positions.resize(used->size());
  for (size_t i = 0; i < used->size(); ++i) {
    accessor.Read((*used)[i], &mesh.positions[i].x);
  }
  const BadTriangles bad = RemoveBadTriangles(mesh.positions, &mesh.indices, primitive->deforms());
  if (bad.not_finite != 0) {
    primitive->log.Warn(fmt::format(
        "{}: {} triangles with positions that are NaN, infinite or beyond {:g} were left out",
        primitive->view.path(), bad.not_finite, kMaxCoordinate));
  }
  if (bad.no_area != 0) {
    primitive->log.Warn(fmt::format("{}: {} triangles without area were left out",
                                    primitive->view.path(), bad.no_area));
  }
  if (bad.not_finite != 0 || bad.no_area != 0) {
    const std::vector<uint32_t> kept = CompactIndices(mesh.positions.size(), &mesh.indices);
    std::vector<uint32_t> file_numbers;
    std::vector<vec3> positions;
    for (const uint32_t vertex : kept) {
      file_numbers.push_back((*used)[vertex]);
      positions.push_back(vec3(mesh.positions[vertex]));
    }
    *used = std::move(file_numbers);
    mesh.positions = std::move(positions);
  }
}

/// Duplicates shared vertices, so that every triangle has its own.
void Unshare(Mesh* mesh, std::vector<uint32_t>* used) {
  std::vector<uint32_t> file_numbers;
  std::vector<vec3> positions;
  for (uint32_t& index : mesh->indices) {
    file_numbers.push_back((*used)[index]);
    positions.push_back(vec3(mesh->positions[index]));
    index = static_cast<uint32_t>(positions.size()) - 1;
  }
  *used = std::move(file_numbers);
  mesh->positions = std::move(positions);
}

void ReadNormals(const GltfDocument& document, Primitive* primitive, size_t vertices,
                 std::vector<uint32_t>* used) {
  Mesh& mesh = primitive->mesh;
  if (primitive->normal < 0) {
    Unshare(&mesh, used);
    ComputeFlatNormals(&mesh);
    mesh.flat_normals = true;
    return;
  }
  Accessor accessor;
  if (!OpenVertexAttribute(document, primitive, primitive->normal, "NORMAL", 3, 3, vertices,
                           &accessor)) {
    return;
  }
  mesh.normals.resize(used->size());
  for (size_t i = 0; i < used->size(); ++i) {
    accessor.Read((*used)[i], &mesh.normals[i].x);
  }
  if (const size_t mended = NormalizeNormals(&mesh)) {
    primitive->log.Warn(fmt::format("{}.NORMAL: {} normals without a direction were computed",
                                    primitive->view.path(), mended));
  }
}

void ReadUvs(const GltfDocument& document, Primitive* primitive, size_t vertices,
             const std::vector<uint32_t>& used) {
  for (size_t set = 0; set < 2; ++set) {
    if (primitive->uv[set] < 0) {
      continue;
    }
    Accessor accessor;
    const char* name = set == 0 ? "TEXCOORD_0" : "TEXCOORD_1";
    if (!OpenVertexAttribute(document, primitive, primitive->uv[set], name, 2, 2, vertices,
                             &accessor)) {
      return;
    }
    std::vector<vec2>& uv = primitive->mesh.uv[set];
    uv.resize(used.size());
    size_t mended = 0;
    for (size_t i = 0; i < used.size(); ++i) {
      accessor.Read(used[i], &uv[i].x);
      if (!(std::abs(uv[i].x) <= kMaxCoordinate && std::abs(uv[i].y) <= kMaxCoordinate)) {
        uv[i] = vec2(0.0f);
        ++mended;
      }
    }
    if (mended != 0) {
      primitive->log.Warn(fmt::format("{}.{}: {} coordinates that are NaN or infinite became 0",
                                      primitive->view.path(), name, mended));
    }
  }
}

void ReadColours(const GltfDocument& document, Primitive* primitive, size_t vertices,
                 const std::vector<uint32_t>& used) {
  Accessor accessor;
  if (primitive->color < 0 || !OpenVertexAttribute(document, primitive, primitive->color, "COLOR_0",
                                                   3, 4, vertices, &accessor)) {
    return;
  }
  std::vector<vec4>& colours = primitive->mesh.colors;
  colours.resize(used.size());
  bool mended = false;
  for (size_t i = 0; i < used.size(); ++i) {
    std::array<float, 4> value = {1.0f, 1.0f, 1.0f, 1.0f};
    accessor.Read(used[i], value.data());
    for (float& component : value) {
      // Also maps NaN to 0. Colours above 1 would violate energy conservation.
      const float clamped = component > 0.0f ? std::min(component, 1.0f) : 0.0f;
      mended = mended || !(clamped == component);
      component = clamped;
    }
    colours[i] = vec4(value[0], value[1], value[2], value[3]);
  }
  if (mended) {
    primitive->log.Warn(
        fmt::format("{}.COLOR_0: values outside 0..1 were clamped", primitive->view.path()));
  }
}

/// The file's tangents; false if they are missing or unusable.
bool ReadTangents(const GltfDocument& document, Primitive* primitive, size_t vertices,
                  const std::vector<uint32_t>& used) {
  // Tangents are only valid with the normals of the file.
  if (primitive->tangent < 0 || primitive->normal < 0) {
    return false;
  }
  Accessor accessor;
  if (!OpenVertexAttribute(document, primitive, primitive->tangent, "TANGENT", 4, 4, vertices,
                           &accessor)) {
    return false;
  }
  constexpr float kShortest = 1e-6f;
  std::vector<vec4>& tangents = primitive->mesh.tangents;
  tangents.resize(used.size());
  for (size_t i = 0; i < used.size(); ++i) {
    std::array<float, 4> value{};
    accessor.Read(used[i], value.data());
    const vec3 direction(value[0], value[1], value[2]);
    const float length = glm::length(direction);
    if (!(length > kShortest) || !std::isfinite(length)) {
      primitive->log.Warn(
          fmt::format("{}.TANGENT: has no direction at vertex {}, so the tangents "
                      "were computed",
                      primitive->view.path(), used[i]));
      tangents.clear();
      return false;
    }
    tangents[i] = vec4(direction / length, value[3] < 0.0f ? -1.0f : 1.0f);
  }
  return true;
}

/// Adds zero texture coordinates to a mesh that needs them but has none.
void ProvideUvs(const Material& material, Primitive* primitive) {
  for (const MaterialTexture& texture : kMaterialTextures) {
    const TextureRef& ref = material.*texture.slot;
    std::vector<vec2>& uv = primitive->mesh.uv[ref.uv_set];
    if (ref.texture >= 0 && uv.empty()) {
      primitive->log.Warn(fmt::format("{}: has no TEXCOORD_{}, which its material's textures need",
                                      primitive->view.path(), ref.uv_set));
      uv.assign(primitive->mesh.positions.size(), vec2(0.0f));
    }
  }
}

/// The texture whose coordinates define the tangents; null if the material needs no tangents.
const TextureRef* TextureOfTangents(const Material& material) {
  if (material.normal_texture.texture >= 0) {
    return &material.normal_texture;
  }
  if (material.clearcoat_normal_texture.texture >= 0) {
    return &material.clearcoat_normal_texture;
  }
  return material.anisotropy > 0.0f ? &material.anisotropy_texture : nullptr;
}

/// Sets the tangents of the file, or computes tangents.
void ProvideTangents(const GltfDocument& document, const Material& material, size_t vertices,
                     const std::vector<uint32_t>& used, Primitive* primitive) {
  const TextureRef* texture = TextureOfTangents(material);
  if (texture == nullptr || ReadTangents(document, primitive, vertices, used) ||
      !primitive->log.ok()) {
    return;
  }
  Mesh& mesh = primitive->mesh;
  if (mesh.uv[texture->uv_set].empty()) {
    primitive->log.Warn(
        fmt::format("{}: has neither TANGENT nor TEXCOORD_{}, by which its material's anisotropy "
                    "is directed: it reflects alike in all directions",
                    primitive->view.path(), texture->uv_set));
    return;
  }
  ComputeTangents(*texture, &mesh);
}

/// Reads all data of a primitive. The mesh is empty if no triangle can be rendered.
void ReadPrimitive(const GltfDocument& document, const std::vector<Material>& materials,
                   Primitive* primitive) {
  Mesh& mesh = primitive->mesh;
  mesh.name = primitive->mesh_name;
  mesh.material = primitive->material;
  Accessor positions;
  if (!OpenAttribute(document, primitive, primitive->position, "POSITION", 3, 3, &positions) ||
      !ReadIndices(document, primitive, positions.count(), &mesh.indices)) {
    return;
  }
  const size_t vertices = positions.count();
  MakeTriangles(primitive, &mesh.indices);
  std::vector<uint32_t> used = CompactIndices(vertices, &mesh.indices);
  ReadPositions(positions, primitive, &used);
  ReadNormals(document, primitive, vertices, &used);
  ReadUvs(document, primitive, vertices, used);
  ReadColours(document, primitive, vertices, used);
  ReadJoints(document, primitive, vertices, used);
  ReadTargets(document, primitive, vertices, used);
  const Material& material = materials[static_cast<size_t>(primitive->material)];
  if (!primitive->log.ok()) {
    return;
  }
  ProvideUvs(material, primitive);
  ProvideTangents(document, material, vertices, used, primitive);
}

/// The primitives of all used meshes, and their indices per glTF mesh.
std::vector<Primitive> PlanPrimitives(GltfImport* import,
                                      std::map<int, std::pair<size_t, size_t>>* range_of_mesh) {
  const JsonView root = import->Root();
  std::vector<Primitive> primitives;
  int default_material = -1;
  for (const GltfMeshUse& use : import->mesh_uses) {
    if (range_of_mesh->count(use.gltf_mesh) != 0) {
      continue;
    }
    const JsonView mesh = root.Item("meshes", static_cast<size_t>(use.gltf_mesh));
    const std::string name = mesh.String("name");
    const size_t first = primitives.size();
    const size_t count = mesh.Size("primitives");
    for (size_t i = 0; i < count && import->log.ok(); ++i) {
      Primitive plan;
      if (!PlanPrimitive(import, mesh.Item("primitives", i), &plan)) {
        continue;
      }
      if (primitives.size() > first && plan.targets.size() != primitives[first].targets.size()) {
        plan.view.Fail("targets", fmt::format("{} morph targets, but {} has {}",
                                              plan.targets.size(), primitives[first].view.path(),
                                              primitives[first].targets.size()));
        break;
      }
      plan.mesh_name = name;
      if (plan.material < 0) {
        plan.material = DefaultMaterial(import, &default_material);
      }
      primitives.push_back(std::move(plan));
    }
    (*range_of_mesh)[use.gltf_mesh] = {first, primitives.size()};
    if (!import->log.ok()) {
      break;
    }
  }
  return primitives;
}

/// The morph target weights of a node: its own weights, else the weights of its mesh, else all 0.
std::vector<float> ReadMorphWeights(const JsonView& root, const GltfMeshUse& use, size_t targets) {
  std::vector<float> weights(targets, 0.0f);
  const JsonView node = root.Item("nodes", static_cast<size_t>(use.gltf_node));
  const JsonView mesh = root.Item("meshes", static_cast<size_t>(use.gltf_mesh));
  for (const JsonView& view : {node, mesh}) {
    if (!view.Has("weights")) {
      continue;
    }
    const size_t count = view.Size("weights");
    if (targets == 0) {
      view.Warn("weights", "are of no use: the mesh has no morph targets");
    } else if (count != targets) {
      view.Fail("weights",
                fmt::format("{} weights, but the mesh has {} morph targets", count, targets));
    } else {
      view.Numbers("weights", weights.data(), targets);
    }
    break;
  }
  return weights;
}

/// The largest joint index, -1 if there are no joints.
int LargestJoint(const Mesh& mesh) {
  const auto largest = std::max_element(mesh.joints.begin(), mesh.joints.end());
  return largest == mesh.joints.end() ? -1 : *largest;
}

/// The skin of a primitive on a node, as an index into Scene::skins; -1: none, or after a failure.
/// \param largest_joint  largest joint index of the primitive
int SkinOf(GltfImport* import, const GltfMeshUse& use, const Primitive& primitive,
           int largest_joint) {
  if (use.gltf_skin < 0) {
    return -1;
  }
  if (largest_joint < 0) {
    import->log.Warn(fmt::format("{}: has no JOINTS_0, so the skin of nodes[{}] does not move it",
                                 primitive.view.path(), use.gltf_node));
    return -1;
  }
  const int skin = import->skin_of_gltf[static_cast<size_t>(use.gltf_skin)];
  const size_t joints = import->scene.skins[static_cast<size_t>(skin)].joints.size();
  if (static_cast<size_t>(largest_joint) >= joints) {
    import->log.Fail(Status::BadData(
        fmt::format("{}.JOINTS_0: joint {} is out of range, skins[{}] of nodes[{}] has {} joints",
                    primitive.view.path(), largest_joint, use.gltf_skin, use.gltf_node, joints)));
    return -1;
  }
  return skin;
}

/// Charges the budget for instances: nodes that share meshes of many primitives create many
/// instances from few bytes.
bool ChargeInstances(GltfImport* import,
                     const std::map<int, std::pair<size_t, size_t>>& range_of_mesh) {
  uint64_t instances = 0;
  for (const GltfMeshUse& use : import->mesh_uses) {
    const auto& [first, last] = range_of_mesh.at(use.gltf_mesh);
    instances += last - first;
  }
  const uint64_t most = std::min(kMaxInstances, import->elements_left / kElementsPerInstance);
  if (instances > most) {
    import->log.Fail(Status::Unsupported(
        fmt::format("the nodes place {} primitives, at most {} are read from a file of {} bytes",
                    instances, most, import->document.total_bytes)));
    return false;
  }
  import->elements_left -= instances * kElementsPerInstance;
  return true;
}

}  // namespace

uint64_t SparseCount(const JsonView& root, int accessor) {
  return accessor < 0 ? 0
                      : root.Item("accessors", static_cast<size_t>(accessor))
                            .Object("sparse")
                            .Count("count", 0);
}

bool OpenAttribute(const GltfDocument& document, Primitive* primitive, int index, const char* name,
                   int min_components, int max_components, Accessor* accessor) {
  const std::string user = primitive->view.path() + "." + name;
  if (!OpenAccessor(document, &primitive->log, index, user, accessor)) {
    return false;
  }
  if (accessor->components() < min_components || accessor->components() > max_components) {
    primitive->log.Fail(
        Status::BadData(fmt::format("{}: accessors[{}] has {} components, expected {}", user, index,
                                    accessor->components(), min_components)));
    return false;
  }
  return true;
}

bool OpenVertexAttribute(const GltfDocument& document, Primitive* primitive, int index,
                         const char* name, int min_components, int max_components, size_t vertices,
                         Accessor* accessor) {
  if (!OpenAttribute(document, primitive, index, name, min_components, max_components, accessor)) {
    return false;
  }
  if (accessor->count() != vertices) {
    primitive->log.Fail(
        Status::BadData(fmt::format("{}.{}: has {} elements, POSITION has {}",
                                    primitive->view.path(), name, accessor->count(), vertices)));
    return false;
  }
  return true;
}

void ImportMeshes(GltfImport* import) {
  std::map<int, std::pair<size_t, size_t>> range_of_mesh;
  std::vector<Primitive> primitives = PlanPrimitives(import, &range_of_mesh);
  if (!import->log.ok()) {
    return;
  }
  tbb::parallel_for(size_t{0}, primitives.size(), [&](size_t i) {
    if (!import->GoesOn()) {
      return;
    }
    primitives[i].view = primitives[i].view.WithLog(&primitives[i].log);
    ReadPrimitive(import->document, import->scene.materials, &primitives[i]);
  });
  if (import->cancelled) {
    import->log.Fail(Status::Cancelled());
    return;
  }
  std::vector<int> scene_mesh(primitives.size(), -1);
  std::vector<int> largest_joint(primitives.size(), -1);
  for (size_t i = 0; i < primitives.size(); ++i) {
    import->log.Append(primitives[i].log);
    largest_joint[i] = LargestJoint(primitives[i].mesh);
    if (!primitives[i].mesh.indices.empty()) {
      scene_mesh[i] = static_cast<int>(import->scene.meshes.size());
      import->scene.meshes.push_back(std::move(primitives[i].mesh));
    }
  }
  if (!import->log.ok() || !ChargeInstances(import, range_of_mesh)) {
    return;
  }
  for (const GltfMeshUse& use : import->mesh_uses) {
    const auto [first, last] = range_of_mesh[use.gltf_mesh];
    const size_t targets = first == last ? 0 : primitives[first].targets.size();
    import->scene.nodes[static_cast<size_t>(use.node)].weights =
        ReadMorphWeights(import->Root(), use, targets);
    for (size_t i = first; i < last && import->log.ok(); ++i) {
      if (scene_mesh[i] < 0) {
        continue;
      }
      const int skin = SkinOf(import, use, primitives[i], largest_joint[i]);
      const Mesh& mesh = import->scene.meshes[static_cast<size_t>(scene_mesh[i])];
      if ((skin < 0 && mesh.targets.empty()) ||
          import->Charge(primitives[i].view.path(),
                         kElementsPerDeformedVertex * mesh.positions.size())) {
        import->scene.instances.push_back({scene_mesh[i], use.node, skin});
      }
    }
    if (!import->log.ok()) {
      return;
    }
  }
}

}  // namespace stillray
