// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// From the accumulated light of all signals to the filtered: variances, levels, and what is fed
// back.
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <string>

#include <fmt/format.h>

#include "core/parallel.h"
#include "denoise/denoiser_impl.h"
#include "denoise/filter_parameters.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

AtrousWeights WeightsOf(Wavelet wavelet) {
  return wavelet == Wavelet::kNaive ? AtrousWeights::kNaive
         : wavelet == Wavelet::kEaw ? AtrousWeights::kEaw
                                    : AtrousWeights::kSvgf;
}

/// Whether light is known on every surface.
bool IsComplete(const Image1& present, const GuidePlanes& guides) {
  std::atomic<bool> complete = true;
  ParallelRows(present.height(), 32, [&](int y0, int y1) {
    if (!complete) {
      return;  // another band has told
    }
    int missing = 0;
    for (int y = y0; y < y1; ++y) {
      const float* i = guides.inverse_depth.Row(y);
      const float* there = present.Row(y);
      for (int x = 0; x < present.width(); ++x) {
        missing += i[x] > 0 && there[x] == 0 ? 1 : 0;
      }
    }
    if (missing > 0) {
      complete = false;
    }
  });
  return complete;
}

/// Between the history before the last feedback and after it (PSVGF section 5).
void BlendFeedback(const SignalHistory& history, float phase, Image3* out) {
  ParallelRows(out->height(), 32, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c) {
      for (int y = y0; y < y1; ++y) {
        const float* before = history.behind[c].Row(y);
        const float* after = history.colour[c].Row(y);
        float* to = (*out)[c].Row(y);
        for (int x = 0; x < out->width(); ++x) {
          to[x] = before[x] + phase * (after[x] - before[x]);
        }
      }
    }
  });
}

}  // namespace

PrefilterVarianceParameters Denoiser::Impl::PrefilterOf() const {
  PrefilterVarianceParameters p;
  p.smooth = settings.prefilter_variance;
  p.square_root = settings.luminance_scale == LuminanceScale::kDeviation;
  p.sigma_l = settings.sigma_l;
  p.luminance_epsilon = settings.luminance_epsilon;
  p.unbounded_below =
      settings.short_history == ShortHistory::kBlur ? ShortHistoryLength(settings) : 0.0f;
  return p;
}

AtrousParameters Denoiser::Impl::LevelParameters(int level) const {
  AtrousParameters p;
  p.step = settings.steps.step[static_cast<size_t>(level)];
  p.radius = settings.kernel == Kernel::k5x5 ? 2 : 1;
  p.weights = WeightsOf(settings.wavelet);
  p.edges = EdgesOf(settings);
  p.test_id = settings.wavelet_id;
  p.noise_ratio = settings.noise_ratio;
  p.eaw_sigma_n = settings.eaw_sigma_n;
  p.eaw_sigma_z = settings.eaw_sigma_z;
  return p;
}

AtrousSignal Denoiser::Impl::LevelSignal(size_t signal, int level) {
  WaveletPlanes& planes = wavelet[signal];
  AtrousSignal s = {planes.light, planes.variance, &planes.filter[planes.target], nullptr,
                    planes.where};
  s.complete = planes.complete;
  s.eaw_sigma_l =
      settings.eaw_sigma_l * planes.mean_luminance * std::exp2f(static_cast<float>(-level));
  s.grown = IsSparse() && !planes.complete ? &planes.grown : nullptr;
  return s;
}

void Denoiser::Impl::FinishLevel(const AtrousSignal& signal, WaveletPlanes* planes) {
  FilterPlanes& filtered = planes->filter[planes->target];
  planes->light = &filtered.colour;
  planes->variance = &filtered.variance;
  planes->target ^= 1;
  if (signal.grown != nullptr) {
    std::swap(planes->present, planes->grown);
    planes->complete = IsComplete(planes->present, state.guides);
  }
}

void Denoiser::Impl::RunLevel(int level) {
  std::array<AtrousSignal, kMostGroups> of_level;
  const std::span<AtrousSignal> signals(of_level.data(), groups.size());
  for (size_t i = 0; i < signals.size(); ++i) {
    WaveletPlanes& planes = wavelet[i];
    signals[i] = LevelSignal(i, level);
    if (settings.wavelet == Wavelet::kSvgf) {
      const StageTimer timer(&out->timings, "prefilter_variance");
      const PrefilterVarianceInput in = {&(*planes.light)[0], planes.variance, planes.where,
                                         &planes.history->length,
                                         planes.complete ? &state.guides.full : nullptr};
      stages->prefilter_variance(in, PrefilterOf(), &planes.stop);
      signals[i].stop = &planes.stop;
    }
  }
  const StageTimer timer(&out->timings, "atrous");
  stages->atrous(signals, state.guides, LevelParameters(level));
  for (size_t i = 0; i < groups.size(); ++i) {
    FinishLevel(signals[i], &wavelet[i]);
  }
}

/// What is wanted of a level's output besides the next level.
void Denoiser::Impl::KeepLevel(int level) {
  const std::string name = outputs.empty() ? "" : fmt::format("atrous{}", level + 1);
  const bool wanted = Wants(name);
  for (size_t i = 0; i < groups.size(); ++i) {
    WaveletPlanes& planes = wavelet[i];
    SignalHistory* history = planes.history;
    if (settings.feedback == level + 1 && feeds_back) {
      if (!history->behind.empty()) {
        std::swap(history->colour, history->behind);
      }
      // What was the history is room for another level now.
      std::swap(history->colour, *planes.light);
      planes.light = &history->colour;
    }
    if (wanted) {
      AddSignal(groups[i], *planes.light, Composite(name));
    }
  }
}

/// Marks where there is light, if that is not everywhere.
void Denoiser::Impl::FindPresent(WaveletPlanes* planes) const {
  const Image1& surface = state.guides.inverse_depth;
  const Image1& length = planes->history->length;
  planes->where = planes->complete ? &surface : &planes->present;
  if (planes->complete) {
    return;
  }
  ParallelRows(state.height, 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* i = surface.Row(y);
      const float* samples = length.Row(y);
      float* to = planes->present.Row(y);
      for (int x = 0; x < state.width; ++x) {
        to[x] = i[x] > 0 && samples[x] > 0 ? 1.0f : 0.0f;
      }
    }
  });
}

void Denoiser::Impl::BeginFilter(size_t signal, SignalHistory* history) {
  const SignalGroup& group = groups[signal];
  KeepImage("accumulated", group, history->colour);
  KeepPlane("history", group, history->length);
  KeepPlane("moment_mean", group, history->mean);
  KeepPlane("moment_variance", group, history->variance);
  if (Wants("temporal")) {
    AddSignal(group, history->colour, Composite("temporal"));
  }
  WaveletPlanes& planes = wavelet[signal];
  planes.history = history;
  planes.light = &history->colour;
  planes.variance = &planes.filter[0].variance;
  planes.target = 1;
  if (settings.wavelet == Wavelet::kOff) {
    return;
  }
  if (IsSparse() && (planes.grown.width() != state.width || planes.grown.height() != state.height ||
                     planes.grown.border() != planes.present.border())) {
    planes.grown = Image1(state.width, state.height, planes.present.border());
  }
  if (settings.wavelet == Wavelet::kEaw) {
    planes.mean_luminance = MeanLuminance(history->colour);
  }
  if (feedback_phase < 1 && !history->behind.empty()) {
    BlendFeedback(*history, feedback_phase, &planes.filter[0].colour);
    planes.light = &planes.filter[0].colour;
  }
}

EstimateVarianceParameters Denoiser::Impl::VarianceParameters() const {
  EstimateVarianceParameters p;
  p.of_mean = settings.variance_of == VarianceOf::kMean;
  p.spatial = settings.short_history == ShortHistory::kSpatial;
  p.short_length = ShortHistoryLength(settings);
  p.least_evidence = IsSparse() ? kLeastEvidence : 0.0f;
  p.boost = settings.short_history_boost;
  p.edges = EdgesOf(settings);
  return p;
}

void Denoiser::Impl::RunEstimateVariance() {
  const StageTimer timer(&out->timings, "estimate_variance");
  std::array<VarianceSignal, kMostGroups> signals;
  for (size_t i = 0; i < groups.size(); ++i) {
    const WaveletPlanes& planes = wavelet[i];
    signals[i] = {planes.history, frame->samples.empty() ? nullptr : &light[i].samples,
                  planes.variance, planes.has_variance ? &planes.open : nullptr, planes.complete};
  }
  stages->estimate_variance({signals.data(), groups.size()}, state.guides, VarianceParameters());
  for (size_t i = 0; i < groups.size(); ++i) {
    wavelet[i].complete = signals[i].complete;
    KeepPlane("variance", groups[i], *wavelet[i].variance);
  }
}

void Denoiser::Impl::FilterSignals() {
  if (settings.wavelet == Wavelet::kOff) {
    return;
  }
  if (settings.wavelet == Wavelet::kSvgf) {
    RunEstimateVariance();
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    WaveletPlanes& planes = wavelet[i];
    if (settings.wavelet != Wavelet::kSvgf) {
      planes.complete = IsComplete(planes.history->length, state.guides);
    }
    FindPresent(&planes);
  }
  for (int level = 0; level < settings.steps.count; ++level) {
    RunLevel(level);
    KeepLevel(level);
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    KeepImage("filtered", groups[i], *wavelet[i].light);
    KeepPlane("filtered_variance", groups[i], *wavelet[i].variance);
  }
}

}  // namespace stillray
