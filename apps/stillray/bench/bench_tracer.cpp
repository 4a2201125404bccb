// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_tracer.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/clock.h"
#include "core/median.h"

namespace stillray {
namespace {

using render::kRayCallCount;
using render::kRayPhaseCount;
using render::RayCall;
using render::RayPhase;

double MinOf(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::min_element(values.begin(), values.end());
}

double MaxOf(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

double Ratio(double a, double b) {
  return b > 0 ? a / b : 0;
}

}  // namespace

Status TracerBench::Prepare(const Scene& scene, const RenderSettings& settings,
                            const RenderMoment& moment) {
  Result<std::unique_ptr<render::RayBench>> rays =
      render::RayBench::Record(scene, settings, moment);
  if (!rays.ok()) {
    return rays.status();
  }
  rays_ = std::move(*rays);
  constexpr int kTrials = 3;
  for (int p = 0; p < kRayPhaseCount; ++p) {
    double best = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      for (int c = 0; c < kRayCallCount; ++c) {
        const auto call = static_cast<RayCall>(c);
        const double rate = rays_->Run(static_cast<RayPhase>(p), call).Rate();
        if (rate > best) {
          best = rate;
          phases_[static_cast<size_t>(p)].best = call;
        }
      }
    }
  }
  return Status::Ok();
}

Status TracerBench::MeasureLoading(const std::string& spec, const RenderSettings& settings) {
  // The first load reads the file from disk.
  constexpr int kLoads = 3;
  for (int i = 0; i < kLoads; ++i) {
    const Clock::time_point start = Clock::now();
    const Result<Scene> scene = LoadScene(spec);
    if (!scene.ok()) {
      return scene.status();
    }
    load_ms_.push_back(MillisecondsSince(start));
    const Clock::time_point loaded = Clock::now();
    const Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(*scene, settings);
    if (!renderer.ok()) {
      return renderer.status();
    }
    build_ms_.push_back(MillisecondsSince(loaded));
  }
  return Status::Ok();
}

void TracerBench::AddFrame(const RenderTimings& t, double frame_ms) {
  frame_ms_.push_back(frame_ms);
  const std::pair<const char*, double> parts[] = {
      {"update", t.update_ms}, {"clear", t.clear_ms},   {"primary", t.primary_ms},
      {"bounce", t.bounce_ms}, {"shadow", t.shadow_ms}, {"shade", t.shade_ms}};
  times_.resize(std::size(parts));
  for (size_t i = 0; i < times_.size(); ++i) {
    times_[i].first = parts[i].first;
    times_[i].second.push_back(parts[i].second);
  }
  const std::pair<uint64_t, double> rays[kRayPhaseCount] = {
      {t.primary_rays, t.primary_ms}, {t.bounce_rays, t.bounce_ms}, {t.shadow_rays, t.shadow_ms}};
  for (size_t p = 0; p < phases_.size(); ++p) {
    if (rays[p].first > 0 && rays[p].second > 0) {
      phases_[p].rates.push_back(static_cast<double>(rays[p].first) / rays[p].second * 1e-3);
    }
  }
}

void TracerBench::RunBare() {
  for (size_t p = 0; p < phases_.size(); ++p) {
    const render::RayRun run = rays_->Run(static_cast<RayPhase>(p), phases_[p].best);
    if (run.rays > 0) {
      phases_[p].bare_rates.push_back(run.Rate());
    }
  }
}

std::string TracerBench::Table() const {
  std::string text = fmt::format(
      "scene: loaded in {:.1f} ms, BVH and tables in {:.1f} ms (least of {})\n"
      "tracing: {:.1f} ms per frame (min {:.1f}); of all threads together",
      MinOf(load_ms_), MinOf(build_ms_), load_ms_.size(), Median(frame_ms_), MinOf(frame_ms_));
  for (const auto& [name, ms] : times_) {
    text += fmt::format(" {} {:.2f}", name, Median(ms));
  }
  text += fmt::format("\n\n{:<24}{:>10}{:>12}{:>12}{:>8}   {}\n", "million rays/s, thread", "rays",
                      "tracer", "Embree", "part", "call");
  for (size_t p = 0; p < phases_.size(); ++p) {
    const Phase& phase = phases_[p];
    const double own = MaxOf(phase.rates);
    const double bare = MaxOf(phase.bare_rates);
    text += fmt::format("  {:<22}{:>10}{:>12.2f}{:>12.2f}{:>7.0f}%   {}\n",
                        RayPhaseName(static_cast<RayPhase>(p)),
                        rays_->ray_count(static_cast<RayPhase>(p)), own, bare,
                        100 * Ratio(own, bare), RayCallName(phase.best));
  }
  return text;
}

nlohmann::ordered_json TracerBench::Json() const {
  using Json = nlohmann::ordered_json;
  Json times = Json::object();
  for (const auto& [name, ms] : times_) {
    times[name] = {{"min_ms", MinOf(ms)}, {"median_ms", Median(ms)}};
  }
  Json rays = Json::object();
  for (size_t p = 0; p < phases_.size(); ++p) {
    const Phase& phase = phases_[p];
    const auto kind = static_cast<RayPhase>(p);
    rays[RayPhaseName(kind)] = {{"rays", rays_->ray_count(kind)},
                                {"mrays_per_s_and_thread", MaxOf(phase.rates)},
                                {"embree_mrays_per_s_and_thread", MaxOf(phase.bare_rates)},
                                {"part", Ratio(MaxOf(phase.rates), MaxOf(phase.bare_rates))},
                                {"embree_call", RayCallName(phase.best)}};
  }
  return {{"load_ms", MinOf(load_ms_)},     {"build_ms", MinOf(build_ms_)},
          {"frame_ms", Median(frame_ms_)},  {"frame_min_ms", MinOf(frame_ms_)},
          {"phases_of_all_threads", times}, {"rays", rays}};
}

}  // namespace stillray
