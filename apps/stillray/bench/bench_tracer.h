// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer's part of `stillray bench`: phases of a frame, and rays per second, compared
/// with a loop that only calls Embree for the same rays.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "benchmarks/ray_bench.h"

namespace stillray {

class TracerBench {
 public:
  /// Records the rays of a frame and finds the call of Embree that is fastest for each phase.
  Status Prepare(const Scene& scene, const RenderSettings& settings, const RenderMoment& moment);
  /// Loads the scene `spec` some times and makes it ready to be traced.
  Status MeasureLoading(const std::string& spec, const RenderSettings& settings);
  /// A frame that took `frame_ms` was rendered.
  void AddFrame(const RenderTimings& timings, double frame_ms);
  /// Runs the bare loops once. Call it in turn with rendering.
  void RunBare();

  std::string Table() const;
  nlohmann::ordered_json Json() const;

 private:
  struct Phase {
    render::RayCall best = render::RayCall::kPacket8;
    std::vector<double> rates;       // of the tracer, million rays per second and thread
    std::vector<double> bare_rates;  // of the loop
  };

  std::unique_ptr<render::RayBench> rays_;
  std::array<Phase, render::kRayPhaseCount> phases_;
  std::vector<std::pair<std::string, std::vector<double>>> times_;  // of frames, ms, by phase
  std::vector<double> frame_ms_;
  std::vector<double> load_ms_;
  std::vector<double> build_ms_;  // BVH and tables
};

}  // namespace stillray
