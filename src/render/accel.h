// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Ray queries; the only module that uses Embree. Static instances are copied into one flat BVH.
/// Moving instances reference the BVH of their mesh, deforming ones a BVH of their own, from a
/// top-level BVH that is updated per frame.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "stillray/scene.h"
#include "stillray/status.h"
#include "stillray/vec.h"

namespace stillray::render {

/// Maximum number of rays in a batch; a multiple of every packet width.
inline constexpr int kBatchCapacity = 1024;
inline constexpr uint32_t kNoHit = 0xffffffffu;

/// Rays as structure of arrays. Directions have unit length.
struct RayBatch {
  int count = 0;
  alignas(64) float origin_x[kBatchCapacity];
  alignas(64) float origin_y[kBatchCapacity];
  alignas(64) float origin_z[kBatchCapacity];
  alignas(64) float direction_x[kBatchCapacity];
  alignas(64) float direction_y[kBatchCapacity];
  alignas(64) float direction_z[kBatchCapacity];
  alignas(64) float end[kBatchCapacity];  ///< distance beyond which hits are ignored

  void Push(vec3 origin, vec3 direction, float far) {
    const int i = count++;
    origin_x[i] = origin.x;
    origin_y[i] = origin.y;
    origin_z[i] = origin.z;
    direction_x[i] = direction.x;
    direction_y[i] = direction.y;
    direction_z[i] = direction.z;
    end[i] = far;
  }
  vec3 Origin(int i) const { return {origin_x[i], origin_y[i], origin_z[i]}; }
  vec3 Direction(int i) const { return {direction_x[i], direction_y[i], direction_z[i]}; }
};

/// The first hit of a ray, at the point (1 - u - v) v0 + u v1 + v v2 of the triangle.
struct Hit {
  float t = 0;
  float u = 0;
  float v = 0;
  uint32_t instance = kNoHit;  ///< index into Scene::instances, or kNoHit
  uint32_t primitive = 0;      ///< triangle of the mesh
};

struct HitBatch {
  alignas(64) float t[kBatchCapacity];
  alignas(64) float u[kBatchCapacity];
  alignas(64) float v[kBatchCapacity];
  alignas(64) uint32_t instance[kBatchCapacity];
  alignas(64) uint32_t primitive[kBatchCapacity];

  Hit Get(int i) const { return {t[i], u[i], v[i], instance[i], primitive[i]}; }
};

/// Whether Embree can instance a mesh with this transform: an animated scale may be zero.
bool IsInvertible(const mat4& transform);

/// How an instance enters the BVH.
struct AccelInstance {
  /// True: a reference to the BVH of its mesh, whose transform may change between calls of Update;
  /// false: its triangles are copied into the flat BVH.
  bool instanced = false;
  bool deforms = false;      ///< instanced, and has its own BVH, which Update rebuilds
  bool see_through = false;  ///< shadow rays call ShadowFilter on its hits
  /// The world-space vertices of a copied instance, followed by one element of padding; must
  /// outlive the Accel.
  const vec3* placed = nullptr;
};

/// Transform and vertices of an instance at the current moment.
struct AccelPlace {
  mat4 world = mat4(1.0f);
  const vec3* positions = nullptr;  ///< positions of the mesh's vertices, before `world`
  uint64_t shape = 0;               ///< changes whenever the positions change
};

/// Computes the transmittance of undeflected light through the surface at `hit`, per channel in
/// 0..1.
class ShadowFilter {
 public:
  virtual ~ShadowFilter() = default;
  virtual vec3 Transmittance(const Hit& hit, vec3 direction) const = 0;
};

/// Queries may run concurrently on several threads; Update must not run concurrently with anything.
class Accel {
 public:
  /// \param places      current placement of each instance
  /// \param filter      must outlive the result; called only for see_through instances
  /// \param keep_going  called from time to time while BVHs are built, from any thread; may be
  ///     empty
  /// \return kOutOfMemory; kUnsupported if the Embree library lacks a required feature; kCancelled
  static Result<std::unique_ptr<Accel>> Create(const Scene& scene,
                                               const std::vector<AccelInstance>& instances,
                                               const std::vector<AccelPlace>& places,
                                               const ShadowFilter& filter,
                                               const KeepGoing& keep_going = {});
  virtual ~Accel() = default;

  /// Applies the new transforms of moving instances, and rebuilds the BVHs of instances whose shape
  /// has changed.
  virtual Status Update(const std::vector<AccelPlace>& places) = 0;

  /// First hits of coherent rays, such as primary rays.
  virtual void IntersectCoherent(const RayBatch& rays, HitBatch* hits) const = 0;
  /// First hits of incoherent rays.
  virtual void IntersectIncoherent(const RayBatch& rays, HitBatch* hits) const = 0;
  /// Transmittance of each ray between origin and end: 0 if an opaque surface occludes it,
  /// otherwise the product over the see-through surfaces, 1 without any.
  virtual void Occluded(const RayBatch& rays, vec3* transmittance) const = 0;

  virtual size_t memory_bytes() const = 0;
};

}  // namespace stillray::render
