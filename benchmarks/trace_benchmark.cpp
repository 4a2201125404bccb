// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// CPU time of a frame of the path tracer, and of Embree alone for its rays, summed over threads:
// built-in scenes, 320x180 pixels, one path per pixel.
//
//   trace_benchmark --benchmark_filter=Frame/cornell --benchmark_repetitions=5
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include "benchmarks/ray_bench.h"
#include "stillray/render.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

RenderSettings Settings(int bounces, int cycle) {
  RenderSettings settings;
  settings.width = 320;
  settings.height = 180;
  settings.bounces = bounces;
  settings.cycle = cycle;
  settings.guides = cycle > 1 ? GuideCoverage::kSparse : GuideCoverage::kFull;
  return settings;
}

void Frame(benchmark::State& state, const std::string& name, int bounces, int cycle) {
  const Result<Scene> scene = MakeBuiltinScene(name);
  const RenderSettings settings = Settings(bounces, cycle);
  Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(*scene, settings);
  if (!renderer.ok()) {
    return state.SkipWithError(renderer.status().message().c_str());
  }
  stillray::Frame frame;
  RenderMoment moment;
  double shade_ms = 0;
  for (auto _ : state) {
    ++moment.frame_index;
    const Status status = (*renderer)->RenderFrame(moment, &frame);
    if (!status.ok()) {
      return state.SkipWithError(status.message().c_str());
    }
    shade_ms += (*renderer)->timings().shade_ms;
  }
  const auto pixels = static_cast<double>(settings.width) * settings.height / cycle;
  state.counters["ns_per_path"] = benchmark::Counter(
      pixels * 1e-9, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["shade_ms"] = benchmark::Counter(shade_ms, benchmark::Counter::kAvgIterations);
}

void Rays(benchmark::State& state, render::RayPhase phase, render::RayCall call) {
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  const auto rays = render::RayBench::Record(*scene, Settings(1, 1), RenderMoment());
  if (!rays.ok()) {
    return state.SkipWithError(rays.status().message().c_str());
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize((*rays)->Run(phase, call).hits);
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations()) *
                          static_cast<int64_t>((*rays)->ray_count(phase)));
}

void AddFrame(const std::string& scene, int bounces, int cycle) {
  const std::string name = "Frame/" + scene + "/bounces:" + std::to_string(bounces) +
                           (cycle > 1 ? "/cycle:" + std::to_string(cycle) : "");
  benchmark::RegisterBenchmark(
      name.c_str(), [=](benchmark::State& state) { Frame(state, scene, bounces, cycle); })
      ->MeasureProcessCPUTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace stillray

int main(int argc, char** argv) {
  using stillray::render::RayCall;
  using stillray::render::RayPhase;
  for (const std::string& scene : stillray::BuiltinSceneNames()) {
    stillray::AddFrame(scene, 1, 1);
    stillray::AddFrame(scene, 4, 1);
    stillray::AddFrame(scene, 4, 128);
  }
  for (int p = 0; p < stillray::render::kRayPhaseCount; ++p) {
    for (int c = 0; c < stillray::render::kRayCallCount; ++c) {
      const auto phase = static_cast<RayPhase>(p);
      const auto call = static_cast<RayCall>(c);
      const std::string name =
          std::string("Embree/") + RayPhaseName(phase) + "/" + RayCallName(call);
      benchmark::RegisterBenchmark(
          name.c_str(), [=](benchmark::State& state) { stillray::Rays(state, phase, call); })
          ->MeasureProcessCPUTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
}
