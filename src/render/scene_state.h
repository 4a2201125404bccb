// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene at one moment: the current and previous transform and vertices of every instance, and
/// the surface properties at a hit.
#pragma once

#include <vector>

#include "render/accel.h"
#include "scene/deform.h"
#include "stillray/scene.h"

namespace stillray::render {

/// The vertices of an instance before its transform: those of its mesh, or deformed ones.
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
  mat4 world = mat4(1.0f);           ///< the identity with a skin, whose vertices are in the world
  mat4 previous_world = mat4(1.0f);  ///< at the previous frame's moment
  VertexArrays vertices;
  VertexArrays previous_vertices;   ///< at the previous frame's moment
  uint64_t shape = 0;               ///< another number whenever `vertices` have changed
  mat3 normal_matrix = mat3(1.0f);  ///< to the world, without normalising
  /// -1 if the transform mirrors: then the front is where triangles are clockwise (glTF 2.0,
  /// 3.7.4).
  float orientation = 1.0f;
  bool moving = false;    ///< its transform or its vertices change
  bool deforms = false;   ///< its vertices change
  bool may_turn = false;  ///< the scene's animation changes more than its place
  /// It enters the BVH as an instance of its mesh, deformed or not: it moves, or it is static and
  /// one of so many instances of a mesh that copies would take too much memory.
  bool instanced = false;
  bool opaque = true;    ///< alpha is 1 everywhere
  bool layered = false;  ///< IsLayered(*material)
  /// The mesh's vertices in the world, plus one; null if instanced.
  const vec3* placed = nullptr;

  /// Since the previous frame.
  bool HasChangedShape() const { return vertices.positions != previous_vertices.positions; }
};

/// Whether a material has more than metallic-roughness and transmission: SurfaceLayers.
bool IsLayered(const Material& material);
bool HasSheen(const Material& material);
bool HasFilm(const Material& material);
/// Whether it bounds a solid in which light is scattered.
bool ScattersInside(const Material& material);

/// The corners of a triangle in the world.
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
  /// Whether any instance may turn.
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
  /// \return the texture's value at the hit, or 1 without a texture
  vec4 TextureValue(const TextureRef& ref, const Hit& hit, bool srgb) const;

 private:
  /// The mesh of an instance in a pose.
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
