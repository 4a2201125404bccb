// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/signals.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/guides.h"
#include "denoise/cpu/coarse_grid.h"
#include "denoise/row_sums.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

SignalHistory EmptyHistory(const CpuPipeline& p, const LayerHistory& history, int border) {
  return SignalHistory(history.width(), history.height(), p.plan.layout.with_compressed,
                       p.plan.layout.with_behind, border);
}

/// The terms of a signal; allocates the variance within pixels if second moments are given.
DemodulateInput RadianceOf(const CpuPipeline& p, const FrameInput& in, const SignalGroup& signal,
                           NewLight* to) {
  DemodulateInput light;
  bool within = false;
  for (const SignalKind kind : signal.kinds) {
    const Signal* part = in.frame.Find(kind);
    if (part == nullptr) {
      continue;
    }
    const Image3& own = AlbedoOf(in.surface, kind);
    light.radiance[light.count] = &part->radiance;
    light.second_moment[light.count] = part->second_moment.empty() ? nullptr : &part->second_moment;
    light.own_albedo[light.count] = own.empty() ? nullptr : &own;
    within = within || !part->second_moment.empty();
    ++light.count;
  }
  light.albedo = AlbedosOf(p.plan.demodulate, signal, in.guides);
  light.luminance_rec601 = p.plan.demodulate.luminance_rec601 != 0;
  light.negative_limit = in.negative_limit;
  light.samples = in.frame.samples.empty() ? nullptr : &in.frame.samples;
  if (within && to->within.empty()) {
    to->within = Image1(in.frame.width, in.frame.height);
  } else if (!within) {
    to->within = Image1();
  }
  return light;
}

void SuppressFireflies(const CpuPipeline& p, NewLight* light, LayerWork* work) {
  if (p.plan.runs.clamp_fireflies) {
    LumaImage3 clamped;
    clamped.channel.swap(work->scratch.channel);
    p.stages.clamp_fireflies(light->colour, light->samples, &work->firefly, &clamped);
    clamped.channel.swap(light->colour.channel);
    work->scratch.channel.swap(clamped.channel);
  } else {
    p.stages.compress_light(&light->colour);
  }
}

/// Chooses the compression scale of a signal, and rescales its history.
void UpdateCompressionScale(const CpuPipeline& p, const NewLight& light,
                            std::vector<double>* row_sums, SignalHistory* history) {
  if (!p.plan.runs.reproject) {
    history->compressed_scale = CompressionScale(0.0f, MeanLuminance(light.colour, row_sums));
    return;
  }
  const float mean = MeanLuminance(history->colour, row_sums);
  const float scale = CompressionScale(history->compressed_scale, mean);
  if (scale != history->compressed_scale) {
    RescaleHistory(scale, history);
  }
}

HistoryLimits LimitsOf(const CpuPipeline& p, const LayerWork& work, size_t signal) {
  const WaveletPlanes& planes = work.wavelet[signal];
  return p.plan.runs.limit_history ? HistoryLimits{&planes.luminance_factor, &planes.ratio,
                                                   p.plan.limit_history.limit_gain}
                                   : HistoryLimits();
}

/// Allocates the ratios of the history at the pixels, if necessary.
void MakeRatioPlanes(const GuidePlanes& guides, LayerWork* work) {
  for (WaveletPlanes& planes : work->wavelet) {
    Image1& ratio = planes.ratio;
    if (ratio.width() != guides.id.width() || ratio.height() != guides.id.height()) {
      ratio = Image1(guides.id.width(), guides.id.height());
    }
  }
}

/// Sets the sum of squared weights of a fetched history to that of its shortened length, from which
/// merge_future computes its weight.
void ShortenByConfidence(const ReprojectionTaps& taps, SignalHistory* fetched) {
  Image1& length = fetched->length;
  for (int y = 0; taps.confidence != nullptr && y < length.height(); ++y) {
    for (int x = 0; x < length.width(); ++x) {
      if (taps.ConfidenceAt(x, y) < 1 && length(x, y) > 0) {
        fetched->weights2(x, y) = std::max(fetched->weights2(x, y), 1.0f / length(x, y));
      }
    }
  }
}

/// Computes ComparedPlanes::moving of all signals. All diffuse signals have the largest value among
/// them, since indirect light changes with the lamp that direct light shows.
void FindMovingLight(const CpuPipeline& p, LayerWork* work) {
  const auto diffuse = static_cast<size_t>(p.plan.limit_history.wide_signals);
  float most = 0;
  for (size_t i = 0; i < work->compared.size(); ++i) {
    ComparedPlanes& compared = work->compared[i];
    compared.moving = p.plan.runs.find_moving_light
                          ? FindMovingLight(compared.work, i < diffuse, compared)
                          : 0.0f;
    most = i < diffuse ? std::max(most, compared.moving) : most;
  }
  for (size_t i = 0; i < std::min(diffuse, work->compared.size()); ++i) {
    work->compared[i].moving = most;
  }
}

/// The outputs "limit" and "ratio".
void KeepLimits(const CpuPipeline& p, const LayerHistory& history, const LayerWork& work,
                FrameOutputs* outputs) {
  for (size_t i = 0; outputs->any() && i < p.plan.signals.size(); ++i) {
    const HistoryLimits limits = LimitsOf(p, work, i);
    SignalHistory before = EmptyHistory(p, history, work.border);
    p.stages.fetch_history(history.signals[i], work.taps, &before);
    Image1& length = before.length;
    for (int y = 0; y < length.height(); ++y) {
      for (int x = 0; x < length.width(); ++x) {
        length(x, y) =
            LimitedLength(length(x, y), before.weights2(x, y), (*limits.bias)(x, y), limits.gain);
      }
    }
    outputs->KeepPlane("limit", p.plan.signals[i], length);
    outputs->KeepPlane("ratio", p.plan.signals[i], *limits.ratio);
  }
}

}  // namespace

AlbedoSum AlbedosOf(const DemodulateParameters& p, const SignalGroup& signal, const Guides& g) {
  AlbedoSum sum;
  sum.channel = signal.channel;
  const auto add = [&](bool used, const Image3& albedo) {
    if (p.demodulate != 0 && used && !albedo.empty()) {
      sum.part[sum.count++] = &albedo;
    }
  };
  add(signal.diffuse_albedo, g.albedo);
  add(signal.specular_albedo, g.specular_albedo);
  add(signal.transmission_albedo, g.transmission_albedo);
  return sum;
}

void GatherLight(const CpuPipeline& p, const FrameInput& in, size_t signal, LayerHistory* history,
                 LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out) {
  const SignalGroup& group = p.plan.signals[signal];
  NewLight& light = work->light[signal];
  {
    const StageTimer timer(&out->timings, "demodulate");
    const DemodulateCounts counts = p.stages.demodulate(RadianceOf(p, in, group, &light), &light);
    if (group.channel <= 0) {  // the other channels have the same invalid pixels
      out->non_finite += counts.non_finite;
      out->negative += counts.negative;
    }
  }
  if (p.plan.runs.clamp_fireflies || p.plan.runs.compress_light) {
    const StageTimer timer(&out->timings, "suppress_fireflies");
    SuppressFireflies(p, &light, work);
  }
  if (p.plan.layout.with_compressed) {
    UpdateCompressionScale(p, light, &work->row_sums, &history->signals[signal]);
  }
  outputs->KeepLight("noisy", group, light.colour);
}

void RunLimitHistory(const CpuPipeline& p, const FrameInput& in, const LayerHistory& history,
                     LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "limit_history");
  const size_t count = p.plan.signals.size();
  MakeCoarsePlanes(history.guides, count, work);
  MakeRatioPlanes(history.guides, work);
  std::array<ComparedSignal, kMostGroups> signals;
  for (size_t i = 0; i < count; ++i) {
    signals[i] = {&work->light[i], &history.signals[i], &work->compared[i]};
  }
  p.stages.compare_with_history({signals.data(), count}, work->taps, history.guides, in.roughness,
                                &work->coarse);
  static_assert(kCorrectHistoryLevels % 2 == 1 && kLimitHistoryLevels % 2 == 0,
                "the results lie in `work` and in `light`, that of the first of two in `work`");
  if (p.plan.limit_history.correct_history != 0) {
    RunComparedLevels(p, kCorrectHistoryLevels, kAllSignals, work);
    if (p.plan.limit_history.wide_signals > 0) {
      RunWideLevel(p, work);
    }
  }
  FindMovingLight(p, work);
  for (ComparedPlanes& compared : work->compared) {
    p.stages.correct_history(compared.work, p.plan.limit_history, &compared);
  }
  RunComparedLevels(p, kLimitHistoryLevels, kAllSignals, work);
  std::array<LimitedSignal, kMostGroups> limited;
  for (size_t i = 0; i < count; ++i) {
    ComparedPlanes& compared = work->compared[i];
    const bool fine = (p.plan.limit_history.fine_signals >> i & 1) != 0;
    MeasureBias(compared.light, fine ? &compared.work : nullptr, p.plan.limit_history, &compared);
    WaveletPlanes& w = work->wavelet[i];
    limited[i] = {&compared, &work->light[i].samples, &w.ratio, &w.luminance_factor};
  }
  p.stages.limit_history({limited.data(), count}, work->coarse, history.guides);
  KeepLimits(p, history, *work, outputs);
}

void KeepAlpha(const CpuPipeline& p, size_t signal, const LayerHistory& history,
               const LayerWork& work, FrameOutputs* outputs) {
  if (!outputs->any()) {
    return;
  }
  const Image1& length = history.signals[signal].length;
  const Image1& samples = work.light[signal].samples;
  Image1 alpha(length.width(), length.height());
  for (int y = 0; y < length.height(); ++y) {
    for (int x = 0; x < length.width(); ++x) {
      alpha(x, y) = UsedAlpha(p.plan.accumulate, length(x, y), samples(x, y),
                              p.plan.runs.reproject ? work.taps.ConfidenceAt(x, y) : 1.0f);
    }
  }
  outputs->KeepPlane("alpha", p.plan.signals[signal], alpha);
}

void RunAccumulate(const CpuPipeline& p, size_t signal, LayerHistory* history, LayerWork* work,
                   DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "accumulate");
  const NewLight& light = work->light[signal];
  const HistoryLimits limits = LimitsOf(p, *work, signal);
  SignalHistory& joined = history->signals[signal];
  if (!p.plan.runs.reproject) {
    if (!work->spare_is_empty) {
      work->spare = EmptyHistory(p, *history, work->border);
      work->spare_is_empty = true;
    }
    p.stages.accumulate(light, work->spare, nullptr, {}, p.plan.accumulate, &joined);
    return;
  }
  if (ChangesInPlace(p.fusion, work->taps, work->staged)) {
    const bool lit_alone = !p.plan.was_fed_back;
    cpu::AccumulateInPlace(light, work->taps, limits, p.plan.accumulate, lit_alone, &work->staged,
                           &joined);
    return;
  }
  work->spare.compressed_scale = joined.compressed_scale;
  p.stages.accumulate(light, joined, &work->taps, limits, p.plan.accumulate, &work->spare);
  std::swap(joined, work->spare);
  work->spare_is_empty = false;
}

SignalHistory* RunMergeFuture(const CpuPipeline& p, size_t signal, const SignalHistory& history,
                              const SignalHistory& future, LayerWork* work, DenoisedFrame* out) {
  work->merged.resize(p.plan.signals.size());
  SignalHistory& both = work->merged[signal];
  const int width = history.length.width();
  const int height = history.length.height();
  if (both.length.width() != width || both.length.height() != height) {
    both = SignalHistory(width, height, false, false, work->border);
  }
  const StageTimer timer(&out->timings, "merge_future");
  p.stages.merge_future(history, future, &both);
  return &both;
}

SignalHistory ShortenedHistory(const CpuPipeline& p, size_t signal, const LayerHistory& history,
                               const LayerWork& work) {
  SignalHistory shortened = EmptyHistory(p, history, work.border);
  if (!p.plan.runs.reproject) {
    return shortened;
  }
  p.stages.fetch_history(history.signals[signal], work.taps, &shortened);
  const HistoryLimits limits = LimitsOf(p, work, signal);
  for (int y = 0; limits.bias != nullptr && y < history.height(); ++y) {
    for (int x = 0; x < history.width(); ++x) {
      const float ratio = (*limits.ratio)(x, y);
      for (int c = 0; c < 3; ++c) {
        shortened.colour[c](x, y) *= ratio;
      }
      shortened.mean(x, y) *= ratio;
      shortened.variance(x, y) *= ratio * ratio;
      const float most = LimitedLength(shortened.length(x, y), shortened.weights2(x, y),
                                       (*limits.bias)(x, y), limits.gain);
      if (most < shortened.length(x, y)) {
        shortened.length(x, y) = most;
        shortened.weights2(x, y) = std::max(shortened.weights2(x, y), 1.0f / most);
      }
    }
  }
  ShortenByConfidence(work.taps, &shortened);
  shortened.compressed = Image1();
  return shortened;
}

}  // namespace stillray
