// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Lower bound of the path tracer's time: Embree alone retraces the rays of a frame.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "stillray/render.h"

namespace stillray::render {

enum class RayPhase : uint8_t { kPrimary, kBounce, kShadow };
inline constexpr int kRayPhaseCount = 3;
const char* RayPhaseName(RayPhase phase);

/// Embree calls for tracing rays.
enum class RayCall : uint8_t { kSingle, kPacket4, kPacket8, kPacket16, kStream };
inline constexpr int kRayCallCount = 5;
const char* RayCallName(RayCall call);

/// The time of a loop over rays, summed over threads, and its results.
struct RayRun {
  double thread_ms = 0;
  uint64_t rays = 0;
  uint64_t hits = 0;

  /// Million rays per second and thread.
  double Rate() const { return thread_ms > 0 ? static_cast<double>(rays) / thread_ms * 1e-3 : 0; }
};

/// The rays of one frame in tracing order, and loops that only call Embree for them: load a packet,
/// trace it, sum the results. The BVH is a flat BVH of all triangles at the frame's moment, without
/// filters, with the path tracer's quality setting.
class RayBench {
 public:
  /// Records the rays by rendering the frame once, on one thread.
  static Result<std::unique_ptr<RayBench>> Record(const Scene& scene,
                                                  const RenderSettings& settings,
                                                  const RenderMoment& moment);
  virtual ~RayBench() = default;

  virtual uint64_t ray_count(RayPhase phase) const = 0;
  /// Traces all rays of the phase once, on all threads of the pool.
  virtual RayRun Run(RayPhase phase, RayCall call) const = 0;
};

}  // namespace stillray::render
