// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/accel.h"

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <string>

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include "render/embree_handles.h"

namespace stillray::render {
namespace {

/// User data of the shadow filter, passed through Embree.
struct ShadowContext {
  RTCIntersectContext base;  // first member: Embree accesses only this part
  const ShadowFilter* filter;
  const RayBatch* rays;
  vec3* transmittance;  // one per ray of the batch
  uint32_t static_id;
};
static_assert(offsetof(ShadowContext, base) == 0);

/// Embree's argument types for packets of this width.
template <int kWidth>
struct Packet;
template <>
struct Packet<4> {
  using RayHit = RTCRayHit4;
  using Ray = RTCRay4;
  static constexpr auto kIntersect = rtcIntersect4;
  static constexpr auto kOccluded = rtcOccluded4;
};
template <>
struct Packet<8> {
  using RayHit = RTCRayHit8;
  using Ray = RTCRay8;
  static constexpr auto kIntersect = rtcIntersect8;
  static constexpr auto kOccluded = rtcOccluded8;
};
template <>
struct Packet<16> {
  using RayHit = RTCRayHit16;
  using Ray = RTCRay16;
  static constexpr auto kIntersect = rtcIntersect16;
  static constexpr auto kOccluded = rtcOccluded16;
};

/// Sets the fields that are equal for all rays and not modified by Embree: once for many packets.
template <int kWidth>
void PrepareRays(typename Packet<kWidth>::Ray* packet, int* valid) {
  for (int i = 0; i < kWidth; ++i) {
    valid[i] = -1;
    packet->tnear[i] = 0.0f;
    packet->time[i] = 0.0f;
    packet->mask[i] = ~0u;
    packet->id[i] = 0;
    packet->flags[i] = 0;
  }
}

/// Fills the packet with rays first, first + 1, ... Lanes beyond the batch are disabled.
template <int kWidth>
void LoadRays(const RayBatch& rays, int first, typename Packet<kWidth>::Ray* packet, int* valid) {
  constexpr size_t kBytes = kWidth * sizeof(float);
  std::memcpy(packet->org_x, rays.origin_x + first, kBytes);
  std::memcpy(packet->org_y, rays.origin_y + first, kBytes);
  std::memcpy(packet->org_z, rays.origin_z + first, kBytes);
  std::memcpy(packet->dir_x, rays.direction_x + first, kBytes);
  std::memcpy(packet->dir_y, rays.direction_y + first, kBytes);
  std::memcpy(packet->dir_z, rays.direction_z + first, kBytes);
  std::memcpy(packet->tfar, rays.end + first, kBytes);
  if (first + kWidth > rays.count) {
    for (int i = 0; i < kWidth; ++i) {
      valid[i] = first + i < rays.count ? -1 : 0;
    }
  }
}

template <int kWidth>
void IntersectBatch(RTCScene scene, const RayBatch& rays, RTCIntersectContextFlags flags,
                    uint32_t static_id, HitBatch* hits) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  typename Packet<kWidth>::RayHit packet;
  alignas(64) int valid[kWidth];
  PrepareRays<kWidth>(&packet.ray, valid);
  for (int first = 0; first < rays.count; first += kWidth) {
    LoadRays<kWidth>(rays, first, &packet.ray, valid);
    for (int i = 0; i < kWidth; ++i) {
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    Packet<kWidth>::kIntersect(valid, scene, &context, &packet);
    for (int i = 0; i < kWidth; ++i) {
      const uint32_t geometry = packet.hit.geomID[i];
      const uint32_t instance = packet.hit.instID[0][i];
      const bool flat = instance == RTC_INVALID_GEOMETRY_ID || instance == static_id;
      hits->t[first + i] = packet.ray.tfar[i];
      hits->u[first + i] = packet.hit.u[i];
      hits->v[first + i] = packet.hit.v[i];
      hits->instance[first + i] =
          geometry == RTC_INVALID_GEOMETRY_ID ? kNoHit : (flat ? geometry : instance);
      hits->primitive[first + i] = packet.hit.primID[i];
    }
  }
}

template <int kWidth>
void OccludedBatch(RTCScene scene, const RayBatch& rays, ShadowContext* context) {
  typename Packet<kWidth>::Ray packet;
  alignas(64) int valid[kWidth];
  PrepareRays<kWidth>(&packet, valid);
  for (int first = 0; first < rays.count; first += kWidth) {
    LoadRays<kWidth>(rays, first, &packet, valid);
    for (int i = 0; i < kWidth; ++i) {
      packet.id[i] = static_cast<unsigned>(first + i);  // identifies the ray in FilterShadows
    }
    Packet<kWidth>::kOccluded(valid, scene, &context->base, &packet);
    for (int i = 0; i < kWidth && first + i < rays.count; ++i) {
      if (packet.tfar[i] < 0) {  // Embree sets tfar to -inf for occluded rays
        context->transmittance[first + i] = vec3(0.0f);
      }
    }
  }
}

/// Called by Embree once for every see-through triangle that a shadow ray crosses.
void FilterShadows(const RTCFilterFunctionNArguments* arguments) {
  auto* context = reinterpret_cast<ShadowContext*>(arguments->context);
  const unsigned n = arguments->N;
  for (unsigned i = 0; i < n; ++i) {
    if (arguments->valid[i] != -1) {
      continue;
    }
    const uint32_t geometry = RTCHitN_geomID(arguments->hit, n, i);
    const uint32_t instance = RTCHitN_instID(arguments->hit, n, i, 0);
    const bool flat = instance == RTC_INVALID_GEOMETRY_ID || instance == context->static_id;
    Hit hit;
    hit.t = RTCRayN_tfar(arguments->ray, n, i);
    hit.u = RTCHitN_u(arguments->hit, n, i);
    hit.v = RTCHitN_v(arguments->hit, n, i);
    hit.instance = flat ? geometry : instance;
    hit.primitive = RTCHitN_primID(arguments->hit, n, i);
    // The world-space direction; Embree's direction is in the space of the instance.
    const auto ray = static_cast<int>(RTCRayN_id(arguments->ray, n, i));
    vec3& light = context->transmittance[ray];
    light *= context->filter->Transmittance(hit, context->rays->Direction(ray));
    if (light.x > 0 || light.y > 0 || light.z > 0) {
      arguments->valid[i] = 0;
    }
  }
}

/// Scenes with at most this many triangles use one flat BVH even if they move: the rebuild per
/// frame takes less time than the ray transforms of instances.
constexpr size_t kMaxRebuilt = 4096;

void PlaceVertices(const Mesh& mesh, const AccelPlace& place, float* vertices) {
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec3 p = vec3(place.world * vec4(place.positions[i], 1.0f));
    vertices[3 * i] = p.x;
    vertices[3 * i + 1] = p.y;
    vertices[3 * i + 2] = p.z;
  }
}

/// Sets the geometry's triangles: shares the mesh's indices, and its vertices if they are in the
/// required space; otherwise stores transformed vertices.
bool FillGeometry(RTCGeometry geometry, const Mesh& mesh, const AccelPlace& place,
                  const vec3* placed) {
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             mesh.indices.data(), 0, 3 * sizeof(uint32_t), mesh.indices.size() / 3);
  if (placed != nullptr) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, placed, 0,
                               sizeof(vec3), mesh.positions.size());
    return true;
  }
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.positions.size()));
  if (vertices == nullptr) {
    return false;
  }
  PlaceVertices(mesh, place, vertices);
  return true;
}

class EmbreeAccel final : public Accel {
 public:
  explicit EmbreeAccel(const ShadowFilter& filter) : filter_(filter) {}

  Status Build(const Scene& scene, const std::vector<AccelInstance>& instances,
               const std::vector<AccelPlace>& places, const KeepGoing& keep_going);
  Status Update(const std::vector<AccelPlace>& places) override;
  void IntersectCoherent(const RayBatch& rays, HitBatch* hits) const override;
  void IntersectIncoherent(const RayBatch& rays, HitBatch* hits) const override;
  void Occluded(const RayBatch& rays, vec3* transmittance) const override;
  size_t memory_bytes() const override { return static_cast<size_t>(bytes_.load()); }

 private:
  static bool CountMemory(void* self, ssize_t bytes, bool /*post*/) {
    static_cast<EmbreeAccel*>(self)->bytes_ += bytes;
    return true;
  }
  static bool Monitor(void* self, double /*steps*/) {
    return static_cast<EmbreeAccel*>(self)->GoesOn();
  }
  bool GoesOn() const { return !keep_going_ || keep_going_(); }
  Status Commit(RTCScene scene, const char* what);
  Status BuildStatic(const Scene& scene, const std::vector<AccelInstance>& instances,
                     const std::vector<AccelPlace>& places);
  Status BuildInstanced(const Scene& scene, const std::vector<AccelInstance>& instances,
                        const std::vector<AccelPlace>& places);
  static void SetVertices(RTCGeometry geometry, const Mesh& mesh, const AccelPlace& place);
  void UpdateFlat(const std::vector<AccelPlace>& places);
  EmbreeScene NewScene(RTCBuildQuality quality, RTCSceneFlags flags);
  Status AddMesh(RTCScene target, const Mesh& mesh, const AccelPlace& place,
                 const AccelInstance& instance, uint32_t id);

  const ShadowFilter& filter_;
  KeepGoing keep_going_;           // called while the BVHs are built
  std::atomic<int64_t> bytes_{0};  // declared before the device, whose destruction still updates it
  EmbreeDevice device_;
  EmbreeScene static_scene_;
  // Per mesh and kind (opaque, see-through): the Embree scene shared by its instances; then one
  // Embree scene per deforming instance.
  std::vector<EmbreeScene> mesh_scenes_;
  struct Instanced {
    uint32_t index;
    EmbreeGeometry geometry;
    const Mesh* mesh;
    RTCScene deformed;  // BVH of a deforming instance; owned by mesh_scenes_
    uint64_t shape;     // AccelPlace::shape of that BVH
  };
  std::vector<Instanced> instanced_;
  EmbreeScene top_scene_;  // null if nothing moves: rays then traverse static_scene_ directly
  uint32_t static_id_ = RTC_INVALID_GEOMETRY_ID;
  RTCScene root_ = nullptr;
  // All triangles are in static_scene_, which is rebuilt when any instance moves.
  bool flat_ = false;
  int widest_packet_ = 4;
};

Status EmbreeAccel::Commit(RTCScene scene, const char* what) {
  rtcCommitScene(scene);
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error == RTC_ERROR_CANCELLED) {
    return Status::Cancelled();
  }
  if (error == RTC_ERROR_OUT_OF_MEMORY) {
    return Status::OutOfMemory(fmt::format("building the BVH of {}: out of memory", what));
  }
  if (error != RTC_ERROR_NONE) {
    return Status::Internal(
        fmt::format("building the BVH of {}: Embree error {}", what, static_cast<int>(error)));
  }
  return Status::Ok();
}

EmbreeScene EmbreeAccel::NewScene(RTCBuildQuality quality, RTCSceneFlags flags) {
  EmbreeScene scene(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene.get(), quality);
  rtcSetSceneFlags(scene.get(), flags);
  rtcSetSceneProgressMonitorFunction(scene.get(), Monitor, this);
  return scene;
}

Status EmbreeAccel::AddMesh(RTCScene target, const Mesh& mesh, const AccelPlace& place,
                            const AccelInstance& instance, uint32_t id) {
  if (!GoesOn()) {
    return Status::Cancelled();
  }
  const EmbreeGeometry geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
  if (!FillGeometry(geometry.get(), mesh, place, instance.instanced ? nullptr : instance.placed)) {
    return Status::OutOfMemory(
        fmt::format("mesh \"{}\": no memory for the BVH's copy of its {} "
                    "vertices",
                    mesh.name, mesh.positions.size()));
  }
  if (instance.see_through) {
    rtcSetGeometryOccludedFilterFunction(geometry.get(), FilterShadows);
  }
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(target, geometry.get(), id);
  return Status::Ok();
}

Status EmbreeAccel::BuildStatic(const Scene& scene, const std::vector<AccelInstance>& instances,
                                const std::vector<AccelPlace>& places) {
  static_scene_ = NewScene(RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_NONE);
  for (size_t i = 0; i < instances.size(); ++i) {
    const Mesh& mesh = scene.meshes[static_cast<size_t>(scene.instances[i].mesh)];
    if ((flat_ || !instances[i].instanced) && !mesh.indices.empty()) {
      STILLRAY_RETURN_IF_ERROR(
          AddMesh(static_scene_.get(), mesh, places[i], instances[i], static_cast<uint32_t>(i)));
      if (instances[i].instanced) {
        RTCGeometry geometry = rtcGetGeometry(static_scene_.get(), static_cast<unsigned>(i));
        rtcRetainGeometry(geometry);
        instanced_.push_back(
            {static_cast<uint32_t>(i), EmbreeGeometry(geometry), &mesh, nullptr, 0});
      }
    }
  }
  return Commit(static_scene_.get(), "what stands still");
}

Status EmbreeAccel::BuildInstanced(const Scene& scene, const std::vector<AccelInstance>& instances,
                                   const std::vector<AccelPlace>& places) {
  top_scene_ = NewScene(RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_DYNAMIC);
  mesh_scenes_.resize(2 * scene.meshes.size() + instances.size());
  for (size_t i = 0; i < instances.size(); ++i) {
    const auto mesh_index = static_cast<size_t>(scene.instances[i].mesh);
    const Mesh& mesh = scene.meshes[mesh_index];
    if (!instances[i].instanced || mesh.indices.empty()) {
      continue;
    }
    const size_t own = 2 * scene.meshes.size() + i;
    const size_t shared = 2 * mesh_index + (instances[i].see_through ? 1 : 0);
    EmbreeScene& mesh_scene = mesh_scenes_[instances[i].deforms ? own : shared];
    if (!mesh_scene) {
      mesh_scene = NewScene(RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_NONE);
      STILLRAY_RETURN_IF_ERROR(
          AddMesh(mesh_scene.get(), mesh, {mat4(1.0f), places[i].positions, 0}, instances[i], 0));
      STILLRAY_RETURN_IF_ERROR(Commit(mesh_scene.get(), mesh.name.c_str()));
    }
    EmbreeGeometry geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(geometry.get(), mesh_scene.get());
    rtcSetGeometryTimeStepCount(geometry.get(), 1);
    rtcAttachGeometryByID(top_scene_.get(), geometry.get(), static_cast<uint32_t>(i));
    instanced_.push_back({static_cast<uint32_t>(i), std::move(geometry), &mesh,
                          instances[i].deforms ? mesh_scene.get() : nullptr, places[i].shape});
  }
  static_id_ = static_cast<uint32_t>(instances.size());
  const EmbreeGeometry fixed(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(fixed.get(), static_scene_.get());
  rtcSetGeometryTimeStepCount(fixed.get(), 1);
  rtcCommitGeometry(fixed.get());
  rtcAttachGeometryByID(top_scene_.get(), fixed.get(), static_id_);
  return Status::Ok();
}

Status EmbreeAccel::Build(const Scene& scene, const std::vector<AccelInstance>& instances,
                          const std::vector<AccelPlace>& places, const KeepGoing& keep_going) {
  keep_going_ = keep_going;
  // Without threads of its own: Embree runs on the shared thread pool.
  device_.reset(rtcNewDevice("start_threads=0,set_affinity=0"));
  if (!device_) {
    return Status::Unsupported(fmt::format("Embree could not be started: error {}",
                                           static_cast<int>(rtcGetDeviceError(nullptr))));
  }
  if (rtcGetDeviceProperty(device_.get(), RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) == 0 ||
      rtcGetDeviceProperty(device_.get(), RTC_DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED) == 0) {
    return Status::Unsupported("this build of Embree lacks triangles or filter functions");
  }
  const auto native = [&](RTCDeviceProperty property) {
    return rtcGetDeviceProperty(device_.get(), property) != 0;
  };
  widest_packet_ = native(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)  ? 16
                   : native(RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) ? 8
                                                                       : 4;
  rtcSetDeviceMemoryMonitorFunction(device_.get(), CountMemory, this);
  bool any_instanced = false;
  for (const AccelInstance& instance : instances) {
    any_instanced |= instance.instanced;
  }
  flat_ = any_instanced && scene.TriangleCount() <= kMaxRebuilt;
  STILLRAY_RETURN_IF_ERROR(BuildStatic(scene, instances, places));
  root_ = static_scene_.get();
  if (any_instanced && !flat_) {
    STILLRAY_RETURN_IF_ERROR(BuildInstanced(scene, instances, places));
    root_ = top_scene_.get();
  }
  const Status updated = Update(places);
  keep_going_ = nullptr;  // frames are cancelled by their progress callback
  return updated;
}

void EmbreeAccel::SetVertices(RTCGeometry geometry, const Mesh& mesh, const AccelPlace& place) {
  PlaceVertices(mesh, place,
                static_cast<float*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0)));
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
}

void EmbreeAccel::UpdateFlat(const std::vector<AccelPlace>& places) {
  for (const Instanced& instance : instanced_) {
    SetVertices(instance.geometry.get(), *instance.mesh, places[instance.index]);
  }
}

Status EmbreeAccel::Update(const std::vector<AccelPlace>& places) {
  if (flat_) {
    UpdateFlat(places);
    return Commit(static_scene_.get(), "what moves");
  }
  if (!top_scene_) {
    return Status::Ok();
  }
  for (Instanced& instance : instanced_) {
    const mat4& transform = places[instance.index].world;
    if (instance.deformed != nullptr && instance.shape != places[instance.index].shape) {
      instance.shape = places[instance.index].shape;
      SetVertices(rtcGetGeometry(instance.deformed, 0), *instance.mesh,
                  {mat4(1.0f), places[instance.index].positions, 0});
      STILLRAY_RETURN_IF_ERROR(Commit(instance.deformed, instance.mesh->name.c_str()));
    }
    if (!IsInvertible(transform)) {
      rtcDisableGeometry(instance.geometry.get());
      continue;
    }
    rtcEnableGeometry(instance.geometry.get());
    rtcSetGeometryTransform(instance.geometry.get(), 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR,
                            &transform[0][0]);
    rtcCommitGeometry(instance.geometry.get());
  }
  return Commit(top_scene_.get(), "what moves");
}

void EmbreeAccel::IntersectCoherent(const RayBatch& rays, HitBatch* hits) const {
  switch (widest_packet_) {
    case 16:
      return IntersectBatch<16>(root_, rays, RTC_INTERSECT_CONTEXT_FLAG_COHERENT, static_id_, hits);
    case 8:
      return IntersectBatch<8>(root_, rays, RTC_INTERSECT_CONTEXT_FLAG_COHERENT, static_id_, hits);
    default:
      return IntersectBatch<4>(root_, rays, RTC_INTERSECT_CONTEXT_FLAG_COHERENT, static_id_, hits);
  }
}

void EmbreeAccel::IntersectIncoherent(const RayBatch& rays, HitBatch* hits) const {
  // Packets of eight are faster than packets of sixteen for incoherent rays.
  if (widest_packet_ >= 8) {
    return IntersectBatch<8>(root_, rays, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, static_id_, hits);
  }
  return IntersectBatch<4>(root_, rays, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT, static_id_, hits);
}

void EmbreeAccel::Occluded(const RayBatch& rays, vec3* transmittance) const {
  ShadowContext context;
  rtcInitIntersectContext(&context.base);
  context.base.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  context.filter = &filter_;
  context.rays = &rays;
  context.transmittance = transmittance;
  context.static_id = static_id_;
  for (int i = 0; i < rays.count; ++i) {
    transmittance[i] = vec3(1.0f);
  }
  switch (widest_packet_) {
    case 16:
      return OccludedBatch<16>(root_, rays, &context);
    case 8:
      return OccludedBatch<8>(root_, rays, &context);
    default:
      return OccludedBatch<4>(root_, rays, &context);
  }
}

}  // namespace

bool IsInvertible(const mat4& transform) {
  const float determinant = glm::determinant(mat3(transform));
  const float inverse = 1.0f / determinant;
  return std::isfinite(determinant) && std::isfinite(inverse) && inverse != 0.0f;
}

Result<std::unique_ptr<Accel>> Accel::Create(const Scene& scene,
                                             const std::vector<AccelInstance>& instances,
                                             const std::vector<AccelPlace>& places,
                                             const ShadowFilter& filter,
                                             const KeepGoing& keep_going) {
  auto accel = std::make_unique<EmbreeAccel>(filter);
  STILLRAY_RETURN_IF_ERROR(accel->Build(scene, instances, places, keep_going));
  return std::unique_ptr<Accel>(std::move(accel));
}

}  // namespace stillray::render
