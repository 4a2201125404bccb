// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene at one moment: the current and previous transform and vertices of every instance, and
/// the surface properties at a hit.
#pragma once

#include <vector>

#include "render/accel.h"
#include "render/footprint_shared.h"
#include "scene/deform.h"
#include "stillray/scene.h"

namespace stillray::render {

/// The object-space vertices of an instance: the vertices of its mesh, or deformed ones.
struct VertexArrays {
  const vec3* positions = nullptr;
  const vec3* normals = nullptr;
  const vec4* tangents = nullptr;  ///< null: none
};

/// One instance at this moment.
struct PlacedInstance {
  const Mesh* mesh = nullptr;
  const Material* material = nullptr;
  int material_index = 0;
  mat4 world = mat4(1.0f);  ///< identity for skinned instances, whose vertices are in world space
  mat4 previous_world = mat4(1.0f);  ///< `world` at the moment of the previous frame
  VertexArrays vertices;
  VertexArrays previous_vertices;   ///< `vertices` at the moment of the previous frame
  uint64_t shape = 0;               ///< changes whenever `vertices` change
  mat3 normal_matrix = mat3(1.0f);  ///< transforms normals to world space, unnormalised
  /// -1 if the transform mirrors: the front face then has clockwise winding (glTF 2.0, 3.7.4).
  float orientation = 1.0f;
  bool moving = false;    ///< its transform or its vertices are animated
  bool deforms = false;   ///< its vertices are animated
  bool may_turn = false;  ///< the animation changes more than its translation
  /// The BVH references its mesh instead of copying it: the instance moves or deforms, or its
  /// static mesh has so many instances that copies would take too much memory.
  bool instanced = false;
  bool opaque = true;    ///< alpha is 1 everywhere
  bool layered = false;  ///< IsLayered(*material)
  /// World-space vertices followed by one element of padding; null if instanced.
  const vec3* placed = nullptr;

  /// Whether the vertices differ from the previous frame's.
  bool HasChangedShape() const { return vertices.positions != previous_vertices.positions; }
};

/// Whether a material has layers beyond metallic-roughness and transmission (SurfaceLayers).
bool IsLayered(const Material& material);
bool HasSheen(const Material& material);
bool HasFilm(const Material& material);
/// Whether the material bounds a solid with a scattering medium.
bool ScattersInside(const Material& material);

/// The world-space corners of a triangle.
struct Triangle {
  vec3 p0, p1, p2;
};

class SceneState {
 public:
  /// \param scene  valid (CheckScene); must outlive this
  explicit SceneState(const Scene& scene);

  /// \return whether any instance has moved or deformed since the last call
  bool Update(double seconds, double previous_seconds);

  const Scene& scene() const { return *scene_; }
  const std::vector<PlacedInstance>& instances() const { return instances_; }
  const PlacedInstance& instance(uint32_t i) const { return instances_[i]; }
  /// Transforms of all nodes at this moment and the previous one.
  const std::vector<mat4>& nodes() const { return nodes_; }
  const std::vector<mat4>& previous_nodes() const { return previous_nodes_; }
  std::vector<AccelPlace> Places() const;
  /// Whether any instance may rotate (PlacedInstance::may_turn).
  bool may_turn() const { return may_turn_; }
  size_t memory_bytes() const;

  static Triangle TriangleOf(const PlacedInstance& instance, uint32_t primitive) {
    const uint32_t* corner = instance.mesh->indices.data() + 3 * static_cast<size_t>(primitive);
    if (instance.placed != nullptr) {
      return {instance.placed[corner[0]], instance.placed[corner[1]], instance.placed[corner[2]]};
    }
    const auto place = [&](uint32_t i) {
      return vec3(instance.world * vec4(instance.vertices.positions[i], 1.0f));
    };
    return {place(corner[0]), place(corner[1]), place(corner[2])};
  }
  /// Interpolated texture coordinates of a set; (0, 0) where the mesh has none.
  static vec2 Uv(const Mesh& mesh, const Hit& hit, int set);
  /// 0: transparent, 1: opaque; in between for AlphaMode::kBlend.
  float Opacity(const Hit& hit) const;
  /// Radiance emitted by the front of the surface, independent of direction.
  vec3 Emission(const Hit& hit) const;

  /// Base colour with alpha: factor, texture and vertex colour.
  vec4 BaseColour(const Hit& hit) const;
  /// Base colour whose texture is averaged over the pixel's part of the triangle, without
  /// transparent texels.
  /// \param within  position of the ray in its pixel, 0..1
  vec3 MeanBaseColour(const Hit& hit, const Footprint& footprint, vec2 within) const;
  /// \return the texture's value at the hit, or 1 without a texture
  vec4 TextureValue(const TextureRef& ref, const Hit& hit, bool srgb) const;

 private:
  ivec2 TapCounts(const Hit& hit, const Footprint& footprint) const;
  static float OpacityOf(const PlacedInstance& instance, float alpha);

  /// A deformed mesh of an instance.
  struct Posed {
    Pose pose;
    DeformedMesh mesh;
    bool known = false;
  };
  struct Deformation {
    size_t instance;
    Posed now;
    Posed before;
  };

  const Scene* scene_;
  void FindDeformations();
  bool UpdateDeformation(double seconds, double previous_seconds, Deformation* deformation);
  void ShareMeshes();
  void PlaceStatic();

  std::vector<PlacedInstance> instances_;
  std::vector<Deformation> deformations_;
  std::vector<std::vector<vec3>> placed_positions_;  // by instance; empty if instanced
  std::vector<mat4> nodes_;
  std::vector<mat4> previous_nodes_;
  bool placed_ = false;
  bool may_turn_ = false;
};

}  // namespace stillray::render
