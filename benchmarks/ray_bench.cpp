// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "benchmarks/ray_bench.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include <embree3/rtcore.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "benchmarks/ray_recorder.h"
#include "render/create_renderer.h"
#include "render/embree_handles.h"
#include "render/tiles.h"

namespace stillray::render {
namespace {

/// Rays per task: about the number of rays that the path tracer processes at a time.
constexpr size_t kTask = 4096;
/// Padding behind the last ray, for packets and streams.
constexpr size_t kPadding = 16;
constexpr int kStreamLength = 64;

/// Copies the seven values of rays first .. first + kWidth - 1 to Embree's structures.
template <int kWidth, typename Ray>
void LoadPacket(const RayLog& log, size_t first, size_t end, Ray* ray, int* valid) {
  float* parts[] = {ray->org_x, ray->org_y, ray->org_z, ray->dir_x,
                    ray->dir_y, ray->dir_z, ray->tfar};
  for (size_t k = 0; k < log.values.size(); ++k) {
    std::memcpy(parts[k], log.values[k].data() + first, kWidth * sizeof(float));
  }
  for (size_t i = 0; i < kWidth; ++i) {
    valid[i] = first + i < end ? -1 : 0;
  }
}

/// Sets the fields that are equal for all rays and not modified by Embree.
template <int kWidth, typename Ray>
void PreparePacket(Ray* ray) {
  for (int i = 0; i < kWidth; ++i) {
    ray->tnear[i] = 0.0f;
    ray->time[i] = 0.0f;
    ray->mask[i] = ~0u;
    ray->id[i] = 0;
    ray->flags[i] = 0;
  }
}

void LoadSingle(const RayLog& log, size_t i, RTCRay* ray) {
  const auto& v = log.values;
  *ray =
      RTCRay{v[0][i], v[1][i], v[2][i], 0.0f, v[3][i], v[4][i], v[5][i], 0.0f, v[6][i], ~0u, 0, 0};
}

/// Calls Embree for the rays of one task. Returns the number of hits.
struct Loop {
  RTCScene scene;
  const RayLog& log;
  RTCIntersectContext* context;
  size_t first;
  size_t end;

  template <int kWidth, typename RayHit, typename Trace>
  uint64_t Packets(const Trace& trace) const {
    uint64_t hits = 0;
    alignas(64) int valid[kWidth];
    RayHit packet;
    PreparePacket<kWidth>(&packet.ray);
    std::fill_n(packet.hit.instID[0], kWidth, RTC_INVALID_GEOMETRY_ID);
    for (size_t i = first; i < end; i += kWidth) {
      LoadPacket<kWidth>(log, i, end, &packet.ray, valid);
      std::fill_n(packet.hit.geomID, kWidth, RTC_INVALID_GEOMETRY_ID);
      trace(valid, scene, context, &packet);
      for (int k = 0; k < kWidth; ++k) {
        hits += valid[k] != 0 && packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID ? 1u : 0u;
      }
    }
    return hits;
  }
  template <int kWidth, typename Ray, typename Trace>
  uint64_t ShadowPackets(const Trace& trace) const {
    uint64_t hits = 0;
    alignas(64) int valid[kWidth];
    Ray packet;
    PreparePacket<kWidth>(&packet);
    for (size_t i = first; i < end; i += kWidth) {
      LoadPacket<kWidth>(log, i, end, &packet, valid);
      trace(valid, scene, context, &packet);
      for (int k = 0; k < kWidth; ++k) {
        hits += valid[k] != 0 && packet.tfar[k] < 0 ? 1u : 0u;
      }
    }
    return hits;
  }
  uint64_t Singles() const {
    uint64_t hits = 0;
    for (size_t i = first; i < end; ++i) {
      RTCRayHit one;
      LoadSingle(log, i, &one.ray);
      one.hit.geomID = one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene, context, &one);
      hits += one.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1u : 0u;
    }
    return hits;
  }
  uint64_t ShadowSingles() const {
    uint64_t hits = 0;
    for (size_t i = first; i < end; ++i) {
      RTCRay one;
      LoadSingle(log, i, &one);
      rtcOccluded1(scene, context, &one);
      hits += one.tfar < 0 ? 1u : 0u;
    }
    return hits;
  }
  uint64_t Streams() const {
    uint64_t hits = 0;
    RTCRayHit many[kStreamLength];
    for (size_t i = first; i < end; i += kStreamLength) {
      const auto n = static_cast<unsigned>(std::min<size_t>(kStreamLength, end - i));
      for (unsigned k = 0; k < n; ++k) {
        LoadSingle(log, i + k, &many[k].ray);
        many[k].hit.geomID = many[k].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      }
      rtcIntersect1M(scene, context, many, n, sizeof(RTCRayHit));
      for (unsigned k = 0; k < n; ++k) {
        hits += many[k].hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1u : 0u;
      }
    }
    return hits;
  }
  uint64_t ShadowStreams() const {
    uint64_t hits = 0;
    RTCRay many[kStreamLength];
    for (size_t i = first; i < end; i += kStreamLength) {
      const auto n = static_cast<unsigned>(std::min<size_t>(kStreamLength, end - i));
      for (unsigned k = 0; k < n; ++k) {
        LoadSingle(log, i + k, &many[k]);
      }
      rtcOccluded1M(scene, context, many, n, sizeof(RTCRay));
      for (unsigned k = 0; k < n; ++k) {
        hits += many[k].tfar < 0 ? 1u : 0u;
      }
    }
    return hits;
  }
  uint64_t Run(RayCall call) const {
    switch (call) {
      case RayCall::kSingle:
        return Singles();
      case RayCall::kPacket4:
        return Packets<4, RTCRayHit4>(rtcIntersect4);
      case RayCall::kPacket8:
        return Packets<8, RTCRayHit8>(rtcIntersect8);
      case RayCall::kPacket16:
        return Packets<16, RTCRayHit16>(rtcIntersect16);
      case RayCall::kStream:
        return Streams();
    }
    return 0;
  }
  uint64_t RunShadow(RayCall call) const {
    switch (call) {
      case RayCall::kSingle:
        return ShadowSingles();
      case RayCall::kPacket4:
        return ShadowPackets<4, RTCRay4>(rtcOccluded4);
      case RayCall::kPacket8:
        return ShadowPackets<8, RTCRay8>(rtcOccluded8);
      case RayCall::kPacket16:
        return ShadowPackets<16, RTCRay16>(rtcOccluded16);
      case RayCall::kStream:
        return ShadowStreams();
    }
    return 0;
  }
};

class EmbreeRayBench final : public RayBench {
 public:
  Status Build(const Scene& scene, double seconds);
  Status RecordFrame(const Scene& scene, const RenderSettings& settings,
                     const RenderMoment& moment);
  uint64_t ray_count(RayPhase phase) const override {
    return logs_[static_cast<size_t>(phase)].count();
  }
  RayRun Run(RayPhase phase, RayCall call) const override;

 private:
  EmbreeDevice device_;
  EmbreeScene scene_;
  RayLogs logs_;
};

Status AddTriangles(RTCDevice device, RTCScene target, const Mesh& mesh, const mat4& world) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.positions.size()));
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(uint32_t), mesh.indices.size() / 3));
  if (vertices == nullptr || indices == nullptr) {
    rtcReleaseGeometry(geometry);
    return Status::OutOfMemory("the benchmark's BVH: out of memory");
  }
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec3 p(world * vec4(mesh.positions[i], 1.0f));
    std::memcpy(vertices + 3 * i, &p, sizeof(p));
  }
  std::memcpy(indices, mesh.indices.data(), mesh.indices.size() * sizeof(uint32_t));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(target, geometry);
  rtcReleaseGeometry(geometry);
  return Status::Ok();
}

Status EmbreeRayBench::Build(const Scene& scene, double seconds) {
  device_.reset(rtcNewDevice("start_threads=0,set_affinity=0"));
  if (!device_) {
    return Status::Unsupported("Embree could not be started");
  }
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_MEDIUM);
  const std::vector<mat4> nodes = NodeTransforms(scene, seconds);
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    if (!mesh.indices.empty()) {
      STILLRAY_RETURN_IF_ERROR(AddTriangles(device_.get(), scene_.get(), mesh,
                                            nodes[static_cast<size_t>(instance.node)]));
    }
  }
  rtcCommitScene(scene_.get());
  return rtcGetDeviceError(device_.get()) == RTC_ERROR_NONE
             ? Status::Ok()
             : Status::OutOfMemory("the benchmark's BVH could not be built");
}

Status EmbreeRayBench::RecordFrame(const Scene& scene, const RenderSettings& settings,
                                   const RenderMoment& moment) {
  Result<std::unique_ptr<Renderer>> renderer = CreateRenderer(
      scene, settings,
      [&](std::unique_ptr<Accel> accel) { return MakeRecordingAccel(std::move(accel), &logs_); });
  if (!renderer.ok()) {
    return renderer.status();
  }
  Frame frame;
  Status status;
  tbb::task_arena one_thread(1);
  one_thread.execute([&] { status = (*renderer)->RenderFrame(moment, &frame); });
  for (RayLog& log : logs_) {
    for (std::vector<float>& values : log.values) {
      values.resize(values.size() + kPadding, 0.0f);
    }
  }
  return status;
}

RayRun EmbreeRayBench::Run(RayPhase phase, RayCall call) const {
  const RayLog& log = logs_[static_cast<size_t>(phase)];
  tbb::enumerable_thread_specific<RayRun> runs;
  const size_t count = log.count();
  tbb::parallel_for(
      size_t{0}, (count + kTask - 1) / kTask, size_t{1},
      [&](size_t task) {
        const DenormalsOff denormals_off;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = phase == RayPhase::kPrimary ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT
                                                    : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
        const Loop loop{scene_.get(), log, &context, task * kTask,
                        std::min(count, (task + 1) * kTask)};
        RayRun& mine = runs.local();
        const PhaseTimer timer(&mine.thread_ms);
        mine.hits += phase == RayPhase::kShadow ? loop.RunShadow(call) : loop.Run(call);
        mine.rays += loop.end - loop.first;
      },
      tbb::simple_partitioner());
  RayRun sum;
  for (const RayRun& run : runs) {
    sum.thread_ms += run.thread_ms;
    sum.rays += run.rays;
    sum.hits += run.hits;
  }
  return sum;
}

}  // namespace

const char* RayPhaseName(RayPhase phase) {
  constexpr const char* kNames[kRayPhaseCount] = {"primary", "bounce", "shadow"};
  return kNames[static_cast<size_t>(phase)];
}

const char* RayCallName(RayCall call) {
  constexpr const char* kNames[kRayCallCount] = {"single", "packets of 4", "packets of 8",
                                                 "packets of 16", "streams"};
  return kNames[static_cast<size_t>(call)];
}

Result<std::unique_ptr<RayBench>> RayBench::Record(const Scene& scene,
                                                   const RenderSettings& settings,
                                                   const RenderMoment& moment) {
  try {
    auto bench = std::make_unique<EmbreeRayBench>();
    RenderSettings without_images = settings;  // only the phases of paths are measured
    without_images.virtual_guides = false;
    STILLRAY_RETURN_IF_ERROR(bench->RecordFrame(scene, without_images, moment));
    STILLRAY_RETURN_IF_ERROR(bench->Build(scene, moment.seconds));
    return std::unique_ptr<RayBench>(std::move(bench));
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("recording the rays of a frame: out of memory");
  }
}

}  // namespace stillray::render
