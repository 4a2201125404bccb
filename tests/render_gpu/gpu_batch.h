// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Batches of rays for tests and measurements: the same ones on the device and by Embree.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "core/random.h"
#include "gpu/timestamps.h"
#include "render/shadow_filter.h"
#include "render/vulkan/gpu_accel.h"

namespace stillray::render {

/// Traces on the device, `capacity` rays at most.
class GpuBatch {
 public:
  GpuBatch(gpu::Device* device, GpuAccel* accel, uint32_t capacity)
      : device_(device), accel_(accel), arena_(&device->context()), times_(&device->context()) {
    const auto add = [&](size_t bytes, gpu::BufferPlace place) {
      return *arena_.AddBuffer(bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, place);
    };
    rays_ = add(capacity * sizeof(GpuRay), gpu::BufferPlace::kUpload);
    results_ = add(capacity * sizeof(GpuHit), gpu::BufferPlace::kDownload);
    status_ = arena_.Allocate();
    if (status_.ok()) {
      status_ = times_.Create(4);
    }
  }

  std::vector<GpuHit> FirstHits(const std::vector<GpuRay>& rays) {
    std::vector<GpuHit> hits(rays.size());
    Run(rays, false, hits.data(), hits.size() * sizeof(GpuHit));
    return hits;
  }
  std::vector<vec3> Transmittance(const std::vector<GpuRay>& rays) {
    std::vector<vec3> lights(rays.size());
    Run(rays, true, lights.data(), lights.size() * sizeof(vec3));
    return lights;
  }

  /// Of everything so far.
  const Status& status() const { return status_; }
  double milliseconds() const { return milliseconds_; }  ///< of the last batch, on the device

 private:
  void Run(const std::vector<GpuRay>& rays, bool shadow, void* out, size_t bytes) {
    if (status_.ok()) {
      status_ = TryRun(rays, shadow, out, bytes);
    }
  }

  Status TryRun(const std::vector<GpuRay>& rays, bool shadow, void* out, size_t bytes) {
    const gpu::DeviceContext& c = device_->context();
    const auto count = static_cast<uint32_t>(rays.size());
    std::memcpy(rays_->mapped, rays.data(),
                std::min<size_t>(rays.size() * sizeof(GpuRay), rays_->size));
    STILLRAY_RETURN_IF_ERROR(arena_.Flush());
    const Result<VkCommandBuffer> commands = device_->Begin();
    if (!commands.ok()) {
      return commands.status();
    }
    accel_->RecordUpdate(*commands);
    times_.Begin(*commands);
    times_.Mark(*commands, "trace");
    const Status recorded = shadow
                                ? accel_->RecordTransmittance(*commands, *rays_, *results_, count)
                                : accel_->RecordFirstHits(*commands, *rays_, *results_, count);
    times_.End(*commands);
    VkMemoryBarrier barrier = {};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    c.vk.CmdPipelineBarrier(*commands, c.shader_stages, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier,
                            0, nullptr, 0, nullptr);
    STILLRAY_RETURN_IF_ERROR(device_->Run());
    STILLRAY_RETURN_IF_ERROR(recorded);
    STILLRAY_RETURN_IF_ERROR(arena_.Invalidate());
    std::memcpy(out, results_->mapped, bytes);
    const std::vector<gpu::DeviceTime> times = times_.Read();
    milliseconds_ = times.empty() ? 0 : times[0].milliseconds;
    return Status::Ok();
  }

  gpu::Device* device_;
  GpuAccel* accel_;
  gpu::Arena arena_;
  gpu::Timestamps times_;
  const gpu::Buffer* rays_ = nullptr;
  const gpu::Buffer* results_ = nullptr;
  Status status_;
  double milliseconds_ = 0;
};

/// Calls body(batch of rays, its first) for all rays.
template <typename Body>
void ForBatches(const std::vector<GpuRay>& rays, const Body& body) {
  const auto batch = std::make_unique<RayBatch>();
  for (size_t first = 0; first < rays.size(); first += kBatchCapacity) {
    batch->count = 0;
    for (size_t i = first; i < std::min(rays.size(), first + kBatchCapacity); ++i) {
      batch->Push(rays[i].origin, rays[i].direction, rays[i].end);
    }
    body(*batch, first);
  }
}

inline std::vector<GpuHit> EmbreeFirstHits(const Accel& accel, const std::vector<GpuRay>& rays) {
  std::vector<GpuHit> hits(rays.size());
  const auto found = std::make_unique<HitBatch>();
  ForBatches(rays, [&](const RayBatch& batch, size_t first) {
    accel.IntersectIncoherent(batch, found.get());
    for (int i = 0; i < batch.count; ++i) {
      const Hit hit = found->Get(i);
      hits[first + static_cast<size_t>(i)] = {hit.t, hit.u, hit.v, hit.instance, hit.primitive};
    }
  });
  return hits;
}

inline std::vector<vec3> EmbreeTransmittance(const Accel& accel, const std::vector<GpuRay>& rays) {
  std::vector<vec3> lights(rays.size() + kBatchCapacity);
  ForBatches(rays, [&](const RayBatch& batch, size_t first) {
    accel.Occluded(batch, lights.data() + first);
  });
  lights.resize(rays.size());
  return lights;
}

/// Uniform on the sphere.
inline vec3 RandomDirection(uint32_t seed) {
  const float z = 1.0f - 2.0f * UniformFloat(HashCombine(seed, 11));
  const float angle = 6.2831853f * UniformFloat(HashCombine(seed, 12));
  const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
  return glm::normalize(vec3(r * std::cos(angle), r * std::sin(angle), z));
}

/// Rays of all directions from points of the box.
inline std::vector<GpuRay> RandomRays(const Aabb& box, int count, uint32_t seed,
                                      float end = std::numeric_limits<float>::infinity()) {
  std::vector<GpuRay> rays;
  for (int i = 0; i < count; ++i) {
    const uint32_t h = HashCombine(seed, static_cast<uint32_t>(i));
    const vec3 u(UniformFloat(HashCombine(h, 1)), UniformFloat(HashCombine(h, 2)),
                 UniformFloat(HashCombine(h, 3)));
    rays.push_back({box.min + (box.max - box.min) * u, end, RandomDirection(h), 0});
  }
  return rays;
}

}  // namespace stillray::render
