// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Each stage of the denoiser separately, vector and scalar, at 1280x720 on all threads available to
// TBB. For complete frames, and for ratios within one run, use stillray bench.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "bench/machine_limits.h"
#include "core/random.h"
#include "denoise/plan.h"
#include "denoise/stage_table.h"

namespace stillray {
namespace {

constexpr int kWidth = 1280;
constexpr int kHeight = 720;
constexpr int kBorder = 32;
constexpr int kSignals = 3;

float Random(int x, int y, int c) {
  return UniformFloat(HashCombine(HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)),
                                  static_cast<uint32_t>(c)));
}

/// The plan of a frame with history, for the preset "default".
const FramePlan& Plan() {
  static const FramePlan plan = MakePlan(Settings(), FrameFacts(), {.has_history = true});
  return plan;
}

/// Intermediate planes of a frame: tilted planes at several depths, smooth subpixel motion, noisy
/// radiance, histories of eight samples.
struct Planes720 {
  Image1 depth{kWidth, kHeight};
  Image3 normal{kWidth, kHeight};
  Plane<uint32_t> id{kWidth, kHeight};
  Image2 motion{kWidth, kHeight};
  Image3 albedo{kWidth, kHeight};
  Image3 radiance{kWidth, kHeight};
  GuidePlanes guides{kWidth, kHeight, kBorder};
  GuidePlanes previous{kWidth, kHeight, kBorder};
  ReprojectionTaps taps{kWidth, kHeight};
  NewLight light{LumaImage3(kWidth, kHeight), Image1(kWidth, kHeight), Image1()};
  SignalHistory history{kWidth, kHeight};
  SignalHistory fetched{kWidth, kHeight};
  std::array<std::array<FilterPlanes, 2>, kSignals> filter;
  std::array<Image1, kSignals> stop;
  Image1 present{kWidth, kHeight, kBorder};
  Image3 picture{kWidth, kHeight};
  Image3 picture2{kWidth, kHeight};

  Planes720();
};

Planes720::Planes720() {
  for (int s = 0; s < kSignals; ++s) {
    filter[static_cast<size_t>(s)] = {FilterPlanes(kWidth, kHeight, kBorder),
                                      FilterPlanes(kWidth, kHeight, kBorder)};
    stop[static_cast<size_t>(s)] = Image1(kWidth, kHeight, kBorder);
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int which = x * 5 / kWidth + y * 3 / kHeight;
      const float angle = 0.3f * static_cast<float>(which) + 0.0002f * static_cast<float>(x);
      depth(x, y) =
          1 / (0.1f + 0.05f * static_cast<float>(which) + 1e-5f * static_cast<float>(x + 2 * y));
      normal[0](x, y) = std::sin(angle);
      normal[2](x, y) = std::cos(angle);
      id(x, y) = static_cast<uint32_t>(which + 1);
      motion[0](x, y) = 0.6f + 1e-4f * static_cast<float>(x);
      motion[1](x, y) = -0.3f;
      present(x, y) = 1;
      light.samples(x, y) = 1;
      history.length(x, y) = 8;
      history.weights2(x, y) = 0.125f;
      history.variance(x, y) = 0.1f;
      for (int c = 0; c < 3; ++c) {
        const float noise = -std::log(1 - Random(x, y, c / 3));
        albedo[c](x, y) = 0.2f + 0.5f * Random(x / 8, y / 8, c);
        radiance[c](x, y) = noise * albedo[c](x, y);
        picture[c](x, y) = picture2[c](x, y) = noise;
        history.colour[c](x, y) = noise;
      }
      for (int s = 0; s < kSignals; ++s) {
        FilterPlanes& f = filter[static_cast<size_t>(s)][0];
        for (int c = 0; c < 3; ++c) {
          f.colour[c](x, y) = -std::log(1 - Random(x, y, s));
        }
        f.variance(x, y) = 0.1f;
        stop[static_cast<size_t>(s)](x, y) = 1.2f;
      }
    }
  }
  cpu::PrepareGuides({&depth, &normal, &id}, &guides);
  cpu::PrepareGuides({&depth, &normal, &id}, &previous);
  cpu::FindTaps(guides, previous, motion, Plan().reproject, &taps);
}

Planes720& Shared() {
  static Planes720 planes;
  return planes;
}

template <typename Body>
void Measure(benchmark::State& state, const Body& body) {
  Shared();
  for ([[maybe_unused]] auto _ : state) {
    body();
  }
  state.SetItemsProcessed(state.iterations() * kWidth * kHeight);
}

/// Arguments: signals, radius, step, whether to use the weights of preset svgf.
void Atrous(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  AtrousParameters parameters = Plan().atrous;
  const AtrousLevel level = {kAtrousSvgf, static_cast<int>(state.range(1)),
                             static_cast<int>(state.range(2))};
  if (state.range(3) != 0) {
    parameters.edges.depth_weight_plane = 0;
    parameters.noise_ratio = 1;
  }
  std::array<AtrousSignal, kSignals> signals;
  for (size_t s = 0; s < signals.size(); ++s) {
    signals[s] = {&p.filter[s][0].colour, &p.filter[s][0].variance, &p.filter[s][1], &p.stop[s],
                  &p.present};
    signals[s].complete = true;
  }
  Measure(state, [&] {
    stages.atrous({signals.data(), static_cast<size_t>(state.range(0))}, p.guides, level,
                  parameters);
  });
}

/// Also reports the ratio to the time of its arithmetic at the peak rate, measured alternately:
/// 15.5 multiply-adds per tap, for one signal.
void AtrousOfOneThread(benchmark::State& state) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  double peak = MultiplyAddsPerSecond();
  Atrous(state, kCpuStages);
  peak = std::max(peak, MultiplyAddsPerSecond());
  const double side = 2.0 * static_cast<double>(state.range(1)) + 1;
  const double work = 15.5 * (side * side - 1) * kWidth * kHeight;
  state.counters["over_peak"] =
      benchmark::Counter(work * static_cast<double>(state.iterations()) / peak,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Minimum memory traffic of a frame with one signal: 72 bytes per pixel.
void Copy(benchmark::State& state) {
  CopyTest copy(size_t{72} * kWidth * kHeight);
  for ([[maybe_unused]] auto _ : state) {
    copy.Run();
  }
}

void PrefilterVariance(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  Measure(state, [&] {
    stages.prefilter_variance({&p.filter[0][0].colour[0], &p.filter[0][0].variance, &p.present,
                               &p.history.length, &p.guides.full},
                              Plan().prefilter_variance, &p.stop[0]);
  });
}

void PrepareGuides(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  Measure(state, [&] { stages.prepare_guides({&p.depth, &p.normal, &p.id}, &p.guides); });
}

void FindTaps(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  Measure(state,
          [&] { stages.find_taps(p.guides, p.previous, p.motion, Plan().reproject, &p.taps); });
}

void FetchHistory(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  Measure(state, [&] { stages.fetch_history(p.history, p.taps, &p.fetched); });
}

void Demodulate(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  DemodulateInput in;
  in.radiance[0] = &p.radiance;
  in.count = 1;
  in.albedo.part[0] = &p.albedo;
  in.albedo.count = 1;
  Measure(state, [&] { benchmark::DoNotOptimize(stages.demodulate(in, &p.light)); });
}

void Accumulate(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  Measure(state, [&] {
    stages.accumulate(p.light, p.history, &p.taps, {}, Plan().accumulate, &p.fetched);
  });
}

void EstimateVariance(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  VarianceSignal signal = {&p.history, &p.light.samples, &p.filter[0][0].variance};
  Measure(state, [&] {
    stages.estimate_variance({&signal, 1}, p.guides, Plan().estimate_variance);
  });
}

void Remodulate(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  SignalLight light;
  light.light = &p.filter[0][0].colour;
  light.albedo.part[0] = &p.albedo;
  light.albedo.count = 1;
  Measure(state, [&] { stages.remodulate({&light, 1}, {}, {false, false}, &p.picture2); });
}

void Antialias(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  const AntialiasInput in = {p.radiance, p.motion, p.guides, &p.history.length};
  Measure(state, [&] { stages.antialias(p.picture, in, Plan().antialias, &p.picture2); });
}

void Fxaa(benchmark::State& state, const StageTable& stages) {
  Planes720& p = Shared();
  Measure(state, [&] { stages.fxaa(p.picture, nullptr, &p.picture2); });
}

/// Smooth radiance with a grid of edges, as in filtered images; noise would consist only of edges.
void FxaaOfAFilteredPicture(benchmark::State& state, const StageTable& stages) {
  Image3 picture(kWidth, kHeight);
  Image3 out(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int cell = (x + y / 3) / 60 + (y + x / 4) / 50;
      for (int c = 0; c < 3; ++c) {
        picture[c](x, y) = 0.2f + 0.3f * Random(cell, 0, c) + 1e-4f * static_cast<float>(x);
      }
    }
  }
  Measure(state, [&] { stages.fxaa(picture, {}, &out); });
}

/// A frame with guides in one of 128 pixels, as from a path tracer.
Frame MakeSparseFrame(int index, float motion) {
  const Planes720& p = Shared();
  Frame f;
  f.width = kWidth;
  f.height = kHeight;
  f.index = index;
  f.samples = Image1(kWidth, kHeight);
  f.guides.depth = Image1(kWidth, kHeight);
  f.guides.normal = f.guides.albedo = f.guides.specular_albedo = Image3(kWidth, kHeight);
  f.emission = f.background = Image3(kWidth, kHeight);
  f.guides.motion = Image2(kWidth, kHeight);
  f.guides.id = Plane<uint32_t>(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (static_cast<int>(128 * Random(x, y, 77)) != index % 128) {
        continue;
      }
      f.samples(x, y) = 1;
      f.guides.depth(x, y) = p.depth(x, y);
      f.guides.id(x, y) = p.id(x, y);
      f.guides.motion[0](x, y) = motion * p.motion[0](x, y);
      f.guides.motion[1](x, y) = motion * p.motion[1](x, y);
      for (int c = 0; c < 3; ++c) {
        f.guides.normal[c](x, y) = p.normal[c](x, y);
        f.guides.albedo[c](x, y) = p.albedo[c](x, y);
        f.guides.specular_albedo[c](x, y) = 0.04f;
        f.emission[c](x, y) = x < 100 && y < 50 ? 3.0f : 0.0f;
      }
    }
  }
  return f;
}

std::vector<Frame> MakeSparseFrames(float motion) {
  std::vector<Frame> frames;
  for (int i = 0; i < 8; ++i) {
    frames.push_back(MakeSparseFrame(i, motion));
  }
  return frames;
}

/// Argument: whether the image moves. Repeats eight frames, which in a static image give
/// the guides of one of 16 pixels.
void FillGuides(benchmark::State& state, const StageTable& stages) {
  static const std::vector<Frame> sequences[2] = {MakeSparseFrames(0), MakeSparseFrames(1)};
  const std::vector<Frame>& frames = sequences[state.range(0)];
  HeldGuides held;
  FillGuidesWork work;
  size_t next = 0;
  Measure(state, [&] {
    stages.fill_guides(frames[next], &held, &work);
    next = (next + 1) % frames.size();
  });
}

void AtrousArguments(benchmark::internal::Benchmark* b) {
  b->ArgNames({"signals", "radius", "step", "svgf"});
  for (const int signals : {1, 2, 3}) {
    for (const int radius : {1, 2}) {
      b->Args({signals, radius, 1, 1});
      b->Args({signals, radius, 1, 0});
      b->Args({signals, radius, 16, 1});
    }
  }
}

BENCHMARK_CAPTURE(Atrous, vector, kCpuStages)->Apply(AtrousArguments)->UseRealTime();
BENCHMARK(Copy)->UseRealTime();
BENCHMARK(AtrousOfOneThread)->Apply(AtrousArguments)->UseRealTime();
BENCHMARK_CAPTURE(Atrous, scalar, kReferenceStages)
    ->ArgNames({"signals", "radius", "step", "svgf"})
    ->Args({1, 2, 1, 1})
    ->UseRealTime();

#define STILLRAY_BENCHMARK_STAGE(stage)                        \
  BENCHMARK_CAPTURE(stage, vector, kCpuStages)->UseRealTime(); \
  BENCHMARK_CAPTURE(stage, scalar, kReferenceStages)->UseRealTime()

STILLRAY_BENCHMARK_STAGE(PrepareGuides);
STILLRAY_BENCHMARK_STAGE(FindTaps);
STILLRAY_BENCHMARK_STAGE(FetchHistory);
STILLRAY_BENCHMARK_STAGE(Demodulate);
STILLRAY_BENCHMARK_STAGE(Accumulate);
STILLRAY_BENCHMARK_STAGE(EstimateVariance);
STILLRAY_BENCHMARK_STAGE(PrefilterVariance);
STILLRAY_BENCHMARK_STAGE(Remodulate);
STILLRAY_BENCHMARK_STAGE(Antialias);
STILLRAY_BENCHMARK_STAGE(Fxaa);
STILLRAY_BENCHMARK_STAGE(FxaaOfAFilteredPicture);

BENCHMARK_CAPTURE(FillGuides, vector, kCpuStages)
    ->ArgName("moves")
    ->DenseRange(0, 1)
    ->UseRealTime();
BENCHMARK_CAPTURE(FillGuides, scalar, kReferenceStages)
    ->ArgName("moves")
    ->DenseRange(0, 1)
    ->UseRealTime();

}  // namespace
}  // namespace stillray
