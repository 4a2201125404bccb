// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer's part of `stillray bench`: phases of a frame, and rays per second, compared
/// with a loop that only calls Embree for identical rays.
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
  /// Records the rays of a frame and determines the fastest Embree call for each phase.
  Status Prepare(const Scene& scene, const RenderSettings& settings, const RenderMoment& moment);
  /// Loads the scene `spec` several times and prepares it for tracing.
  Status MeasureLoading(const std::string& spec, const RenderSettings& settings);
  /// Adds the timings of a rendered frame.
  void AddFrame(const RenderTimings& timings, double frame_ms);
  /// Runs the Embree loops once. Call it alternately with rendering.
  void RunBare();

  std::string Table() const;
  nlohmann::ordered_json Json() const;

 private:
  struct Phase {
    render::RayCall best = render::RayCall::kPacket8;
    std::vector<double> rates;       // path tracer, million rays per second and thread
    std::vector<double> bare_rates;  // Embree loop, million rays per second and thread
  };

  std::unique_ptr<render::RayBench> rays_;
  std::array<Phase, render::kRayPhaseCount> phases_;
  std::vector<std::pair<std::string, std::vector<double>>> times_;  // frame times in ms, by phase
  std::vector<double> frame_ms_;
  std::vector<double> load_ms_;
  std::vector<double> build_ms_;  // build of BVH and tables
};

}  // namespace stillray
