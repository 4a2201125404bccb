// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <tiny_obj_loader.h>
#include <glm/vec3.hpp>

#include "core/colour_shared.h"
#include "scene/mesh_tools.h"
#include "scene/obj_import.h"

namespace stillray {

namespace {

using glm::dvec3;

/// Maximum number of meshes, each of which takes about a kilobyte.
constexpr size_t kMaxMeshes = 250'000;

struct Triangle {
  std::array<tinyobj::index_t, 3> corners;
  uint32_t smoothing = 0;  ///< 0: flat
};

struct Source {
  tinyobj::attrib_t attributes;
  std::vector<vec3> positions;
  /// Triangles by group and material, as indices into ObjText; -1: none.
  std::map<std::pair<int, int>, std::vector<Triangle>> parts;
  /// Position and smoothing group -> sum of adjacent normals, weighted by angle.
  std::unordered_map<uint64_t, dvec3> smooth_normals;
};

/// Provides the parser with materials by number.
class MaterialNumbers : public tinyobj::MaterialReader {
 public:
  explicit MaterialNumbers(size_t count) : count_(count) {}
  bool operator()(const std::string& /*file*/, std::vector<tinyobj::material_t>* /*materials*/,
                  std::map<std::string, int>* numbers, std::string* /*warning*/,
                  std::string* /*error*/) override {
    for (size_t i = 0; i < count_; ++i) {
      (*numbers)[std::to_string(i)] = static_cast<int>(i);
    }
    return true;
  }

 private:
  size_t count_;
};

uint64_t SmoothKey(int position, uint32_t smoothing) {
  return uint64_t{static_cast<uint32_t>(position)} << 32 | smoothing;
}

/// Weights by angle (Thuermer and Wuethrich 1998): the result is independent of the triangulation
/// of polygons.
void AddToSmoothNormals(const Triangle& triangle, Source* source) {
  if (triangle.smoothing == 0) {
    return;
  }
  std::array<dvec3, 3> p;
  for (size_t c = 0; c < 3; ++c) {
    p[c] = source->positions[static_cast<size_t>(triangle.corners[c].vertex_index)];
  }
  const dvec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
  for (size_t c = 0; c < 3; ++c) {
    if (triangle.corners[c].normal_index < 0) {
      const dvec3 next = glm::normalize(p[(c + 1) % 3] - p[c]);
      const dvec3 last = glm::normalize(p[(c + 2) % 3] - p[c]);
      const double angle = std::acos(std::clamp(glm::dot(next, last), -1.0, 1.0));
      const auto [sum, is_new] = source->smooth_normals.try_emplace(
          SmoothKey(triangle.corners[c].vertex_index, triangle.smoothing), dvec3(0.0));
      sum->second += angle * normal;
    }
  }
}

bool IsSound(const tinyobj::attrib_t& attributes, const tinyobj::index_t& corner) {
  const auto below = [](int index, size_t count) {
    return index < 0 || static_cast<size_t>(index) < count;
  };
  return corner.vertex_index >= 0 && below(corner.vertex_index, attributes.vertices.size() / 3) &&
         below(corner.normal_index, attributes.normals.size() / 3) &&
         below(corner.texcoord_index, attributes.texcoords.size() / 2);
}

/// Sorts the triangles of a shape into the parts.
void AddShape(const tinyobj::shape_t& shape, ImportLog* log, BadTriangles* bad, Source* source) {
  int group = -1;
  std::from_chars(shape.name.data(), shape.name.data() + shape.name.size(), group);
  const tinyobj::mesh_t& mesh = shape.mesh;
  for (size_t i = 0; i < mesh.num_face_vertices.size(); ++i) {
    Triangle triangle;
    std::copy_n(mesh.indices.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                triangle.corners.begin());
    triangle.smoothing = mesh.smoothing_group_ids[i];
    if (!std::all_of(triangle.corners.begin(), triangle.corners.end(),
                     [&](const auto& corner) { return IsSound(source->attributes, corner); })) {
      log->Fail(Status::BadData("a face has a corner that is not in the file"));
      return;
    }
    const std::array<uint32_t, 3> at = {static_cast<uint32_t>(triangle.corners[0].vertex_index),
                                        static_cast<uint32_t>(triangle.corners[1].vertex_index),
                                        static_cast<uint32_t>(triangle.corners[2].vertex_index)};
    const TriangleFault fault = FaultOf(source->positions, at.data());
    bad->not_finite += fault == TriangleFault::kNotFinite ? 1 : 0;
    bad->no_area += fault == TriangleFault::kNoArea ? 1 : 0;
    if (fault == TriangleFault::kNone) {
      AddToSmoothNormals(triangle, source);
      source->parts[{group, mesh.material_ids[i]}].push_back(triangle);
    }
  }
}

void Parse(ObjImport* import, Source* source) {
  // The parser requests the materials at the first mtllib.
  std::istringstream text("mtllib numbers\n" + import->text.text);
  import->text.text = std::string();
  MaterialNumbers numbers(import->text.materials.size());
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning;
  std::string error;
  if (!tinyobj::LoadObj(&source->attributes, &shapes, &materials, &warning, &error, &text, &numbers,
                        true, false)) {
    import->log.Fail(Status::BadData(Printable(error)));
    return;
  }
  const std::vector<tinyobj::real_t>& v = source->attributes.vertices;
  for (size_t i = 0; i + 2 < v.size(); i += 3) {
    source->positions.emplace_back(v[i], v[i + 1], v[i + 2]);
  }
  BadTriangles bad;
  for (const tinyobj::shape_t& shape : shapes) {
    AddShape(shape, &import->log, &bad, source);
  }
  if (bad.not_finite != 0) {
    import->log.Warn(fmt::format("{} triangles with positions beyond {:g} were left out",
                                 bad.not_finite, kMaxCoordinate));
  }
  if (bad.no_area != 0) {
    import->log.Warn(fmt::format("{} triangles without area were left out", bad.no_area));
  }
}

/// Makes the mesh of one part.
class MeshMaker {
 public:
  explicit MeshMaker(const Source& source) : source_(source) {}

  Mesh Make(const std::vector<Triangle>& triangles) {
    has_uv_ = std::any_of(triangles.begin(), triangles.end(), [](const Triangle& triangle) {
      return std::any_of(triangle.corners.begin(), triangle.corners.end(),
                         [](const auto& corner) { return corner.texcoord_index >= 0; });
    });
    for (const Triangle& triangle : triangles) {
      for (const tinyobj::index_t& corner : triangle.corners) {
        AddCorner(triangle, corner);
      }
    }
    return std::move(mesh_);
  }

 private:
  /// Corners with equal indices share a vertex, except in flat triangles without normals.
  void AddCorner(const Triangle& triangle, const tinyobj::index_t& corner) {
    const auto next = static_cast<uint32_t>(mesh_.positions.size());
    const bool flat = corner.normal_index < 0 && triangle.smoothing == 0;
    if (!flat) {
      const int64_t normal =
          corner.normal_index >= 0 ? int64_t{corner.normal_index} : -int64_t{triangle.smoothing};
      const auto [known, is_new] =
          vertices_.try_emplace({corner.vertex_index, corner.texcoord_index, normal}, next);
      mesh_.indices.push_back(known->second);
      if (!is_new) {
        return;
      }
    } else {
      mesh_.indices.push_back(next);
    }
    const auto at = static_cast<size_t>(corner.vertex_index);
    mesh_.positions.push_back(vec3(source_.positions[at]));
    mesh_.normals.push_back(Normal(triangle, corner));
    if (has_uv_) {
      mesh_.uv[0].push_back(Uv(corner.texcoord_index));
    }
    AddColour(at);
  }

  vec3 Normal(const Triangle& triangle, const tinyobj::index_t& corner) const {
    if (corner.normal_index >= 0) {
      const tinyobj::real_t* n =
          &source_.attributes.normals[3 * static_cast<size_t>(corner.normal_index)];
      return {n[0], n[1], n[2]};
    }
    if (triangle.smoothing == 0) {
      return vec3(0.0f);  // NormalizeNormals replaces it by the triangle normal
    }
    const auto sum =
        source_.smooth_normals.find(SmoothKey(corner.vertex_index, triangle.smoothing));
    return sum == source_.smooth_normals.end() ? vec3(0.0f) : vec3(sum->second);
  }

  /// Texture coordinate, flipped since OBJ's v points up.
  vec2 Uv(int index) const {
    if (index < 0) {
      return vec2(0.0f);
    }
    const tinyobj::real_t* t = &source_.attributes.texcoords[2 * static_cast<size_t>(index)];
    const bool sound = std::abs(t[0]) <= kMaxCoordinate && std::abs(t[1]) <= kMaxCoordinate;
    return sound ? vec2(t[0], 1.0f - t[1]) : vec2(0.0f);
  }

  /// Vertex colours, which follow positions, are sRGB-encoded by common exporters.
  void AddColour(size_t vertex) {
    const std::vector<tinyobj::real_t>& colours = source_.attributes.colors;
    if (colours.size() != source_.attributes.vertices.size()) {
      return;
    }
    vec4 colour(1.0f);
    for (int c = 0; c < 3; ++c) {
      colour[c] = SrgbDecode(std::clamp(colours[3 * vertex + static_cast<size_t>(c)], 0.0f, 1.0f));
    }
    mesh_.colors.push_back(colour);
  }

  const Source& source_;
  bool has_uv_ = false;
  Mesh mesh_;
  std::map<std::tuple<int, int, int64_t>, uint32_t> vertices_;
};

bool UsesTextures(const Material& material) {
  return std::max({material.base_color_texture.texture, material.emissive_texture.texture,
                   material.metallic_roughness_texture.texture, material.normal_texture.texture}) >=
         0;
}

/// Adds attributes that the material needs and the file lacks.
void CompleteMesh(const Material& material, bool warn_about_normals, ImportLog* log, Mesh* mesh) {
  const size_t mended = NormalizeNormals(mesh);
  if (warn_about_normals && mended != 0) {
    log->Warn(fmt::format("group '{}': {} normals without a direction were computed",
                          Printable(mesh->name), mended));
  }
  if (UsesTextures(material) && mesh->uv[0].empty()) {
    log->Warn(fmt::format("group '{}' has no texture coordinates, which its material '{}' needs",
                          Printable(mesh->name), Printable(material.name)));
    mesh->uv[0].assign(mesh->positions.size(), vec2(0.0f));
  }
  if (material.normal_texture.texture >= 0) {
    ComputeTangents(material.normal_texture, mesh);
  }
}

/// The scene's material for a material number; faces without a material share a neutral one.
int SceneMaterial(ObjImport* import, int number, int* neutral) {
  if (number >= 0) {
    return import->material_of_name[static_cast<size_t>(number)];
  }
  if (*neutral < 0) {
    *neutral = static_cast<int>(import->scene.materials.size());
    import->scene.materials.push_back(NeutralObjMaterial("default"));
  }
  return *neutral;
}

}  // namespace

void ImportObjMeshes(ObjImport* import) {
  Source source;
  Parse(import, &source);
  if (!import->log.ok()) {
    return;
  }
  if (source.parts.size() > kMaxMeshes) {
    import->log.Fail(Status::Unsupported(
        fmt::format("the groups and materials divide the faces into {} meshes, at most {} are read",
                    source.parts.size(), kMaxMeshes)));
    return;
  }
  int neutral = -1;
  int group = -2;  // group of the last node
  for (const auto& [key, triangles] : source.parts) {
    if (import->keep_going && !import->keep_going()) {
      import->log.Fail(Status::Cancelled());
      return;
    }
    Scene& scene = import->scene;
    if (key.first != group) {
      group = key.first;
      scene.nodes.emplace_back();
      scene.nodes.back().name = group < 0 ? "" : import->text.groups[static_cast<size_t>(group)];
    }
    Mesh mesh = MeshMaker(source).Make(triangles);
    mesh.name = scene.nodes.back().name;
    mesh.material = SceneMaterial(import, key.second, &neutral);
    const bool all_given =
        std::all_of(triangles.begin(), triangles.end(), [](const Triangle& triangle) {
          return std::all_of(triangle.corners.begin(), triangle.corners.end(),
                             [](const auto& corner) { return corner.normal_index >= 0; });
        });
    CompleteMesh(scene.materials[static_cast<size_t>(mesh.material)], all_given, &import->log,
                 &mesh);
    scene.instances.push_back(
        {static_cast<int>(scene.meshes.size()), static_cast<int>(scene.nodes.size()) - 1});
    scene.meshes.push_back(std::move(mesh));
  }
}

}  // namespace stillray
