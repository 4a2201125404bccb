// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Ray queries: the one place that knows Embree. Instances that never move lie in one flat BVH;
/// those that move are instances of their mesh's BVH in a top level that is updated per frame.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "stillray/scene.h"
#include "stillray/status.h"
#include "stillray/vec.h"

namespace stillray::render {

/// Rays that one batch holds; a multiple of every packet width.
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
  alignas(64) float end[kBatchCapacity];  ///< distance beyond which nothing counts

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

/// What a ray met first. The point is (1 - u - v) v0 + u v1 + v v2 of the triangle.
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

/// Whether Embree can instance a mesh with it: an animated scale may well be zero.
bool IsInvertible(const mat4& transform);

/// What an instance is to the BVH.
struct AccelInstance {
  /// It enters the BVH as an instance of its mesh, and its transform may change between calls of
  /// Update; else it is copied.
  bool instanced = false;
  bool see_through = false;  ///< shadow rays ask ShadowFilter about it
  /// Of what is copied: its vertices in the world, and one more behind; must outlive the Accel.
  const vec3* placed = nullptr;
};

/// Tells how much light passes the surface at `hit` straight on, per channel in 0..1.
class ShadowFilter {
 public:
  virtual ~ShadowFilter() = default;
  virtual vec3 Transmittance(const Hit& hit, vec3 direction) const = 0;
};

/// All queries may be called from several threads at once; Update may not.
class Accel {
 public:
  /// \param transforms  of each instance to the world, now
  /// \param filter      must outlive the result; asked only about see_through instances
  /// \param keep_going  called now and then while BVHs are built, from any thread; may be empty
  /// \return kOutOfMemory; kUnsupported if the Embree library lacks a needed feature; kCancelled
  static Result<std::unique_ptr<Accel>> Create(const Scene& scene,
                                               const std::vector<AccelInstance>& instances,
                                               const std::vector<mat4>& transforms,
                                               const ShadowFilter& filter,
                                               const KeepGoing& keep_going = {});
  virtual ~Accel() = default;

  /// Moves the moving instances.
  virtual Status Update(const std::vector<mat4>& transforms) = 0;

  /// First hits of rays that lie close together and run the same way, such as primary rays.
  virtual void IntersectCoherent(const RayBatch& rays, HitBatch* hits) const = 0;
  /// First hits of rays that have nothing to do with each other.
  virtual void IntersectIncoherent(const RayBatch& rays, HitBatch* hits) const = 0;
  /// Light that comes through from each ray's end to its origin: 1, or 0 where something opaque
  /// stands between, or the product of what the see-through surfaces leave.
  virtual void Occluded(const RayBatch& rays, vec3* transmittance) const = 0;

  virtual size_t memory_bytes() const = 0;
};

}  // namespace stillray::render
