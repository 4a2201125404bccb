// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/signals.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/guides.h"
#include "denoise/row_sums.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

SignalHistory EmptyHistory(const CpuPipeline& p, const History& history, int border) {
  return SignalHistory(history.width, history.height, p.plan.layout.with_compressed,
                       p.plan.layout.with_behind, border);
}

/// The lights of a signal; allocates the variance within pixels if second moments are given.
DemodulateInput RadianceOf(const CpuPipeline& p, const FrameInput& in, const SignalGroup& signal,
                           NewLight* to) {
  DemodulateInput light;
  bool within = false;
  for (const SignalKind kind : signal.kinds) {
    const Signal* part = in.frame.Find(kind);
    if (part == nullptr) {
      continue;
    }
    const Image3& own = AlbedoOf(in.guides, kind);
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

void SuppressFireflies(const CpuPipeline& p, NewLight* light, FrameWork* work) {
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

const Image1* LimitOf(const CpuPipeline& p, const FrameWork& work, size_t signal) {
  return p.plan.runs.limit_history ? &work.wavelet[signal].luminance_factor : nullptr;
}

}  // namespace

AlbedoSum AlbedosOf(const DemodulateParameters& p, const SignalGroup& signal, const Guides& g) {
  AlbedoSum sum;
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

void GatherLight(const CpuPipeline& p, const FrameInput& in, size_t signal, History* history,
                 FrameWork* work, FrameOutputs* outputs, DenoisedFrame* out) {
  const SignalGroup& group = p.plan.signals[signal];
  NewLight& light = work->light[signal];
  {
    const StageTimer timer(&out->timings, "demodulate");
    const DemodulateCounts counts = p.stages.demodulate(RadianceOf(p, in, group, &light), &light);
    out->non_finite += counts.non_finite;
    out->negative += counts.negative;
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

void RunLimitHistory(const CpuPipeline& p, const History& history, FrameWork* work,
                     FrameOutputs* outputs, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "limit_history");
  const size_t count = p.plan.signals.size();
  for (size_t i = 0; i < count; ++i) {
    WaveletPlanes& w = work->wavelet[i];
    p.stages.compare_with_history(work->light[i], history.signals[i], work->taps, history.guides,
                                  &w.filter[0], &w.valid);
  }
  std::array<AtrousSignal, kMostGroups> signals;
  int source = 0;
  for (int level = 0; level < kLimitHistoryLevels; ++level, source ^= 1) {
    for (size_t i = 0; i < count; ++i) {
      WaveletPlanes& w = work->wavelet[i];
      const FilterPlanes& from = w.filter[source];
      signals[i] = {&from.colour, &from.variance, &w.filter[source ^ 1], nullptr, &w.valid};
    }
    p.stages.atrous({signals.data(), count}, history.guides, GeometryLevel(level), p.plan.atrous);
  }
  for (size_t i = 0; i < count; ++i) {
    WaveletPlanes& w = work->wavelet[i];
    p.stages.limit_history(w.filter[source], w.valid, history.signals[i], work->taps,
                           p.plan.limit_history, &w.luminance_factor);
    outputs->KeepPlane("limit", p.plan.signals[i], w.luminance_factor);
  }
}

void RunAccumulate(const CpuPipeline& p, size_t signal, History* history, FrameWork* work,
                   DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "accumulate");
  const NewLight& light = work->light[signal];
  const Image1* limit = LimitOf(p, *work, signal);
  SignalHistory& joined = history->signals[signal];
  if (!p.plan.runs.reproject) {
    if (!work->spare_is_empty) {
      work->spare = EmptyHistory(p, *history, work->border);
      work->spare_is_empty = true;
    }
    p.stages.accumulate(light, work->spare, nullptr, nullptr, p.plan.accumulate, &joined);
    return;
  }
  if (ChangesInPlace(p.fusion, work->taps, work->staged)) {
    const bool lit_alone = !history->progress.fed_back;
    cpu::AccumulateInPlace(light, work->taps, limit, p.plan.accumulate, lit_alone, &work->staged,
                           &joined);
    return;
  }
  work->spare.compressed_scale = joined.compressed_scale;
  p.stages.accumulate(light, joined, &work->taps, limit, p.plan.accumulate, &work->spare);
  std::swap(joined, work->spare);
  work->spare_is_empty = false;
}

SignalHistory* RunMergeFuture(const CpuPipeline& p, size_t signal, const SignalHistory& history,
                              const SignalHistory& future, FrameWork* work, DenoisedFrame* out) {
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

SignalHistory ShortenedHistory(const CpuPipeline& p, size_t signal, const History& history,
                               const FrameWork& work) {
  SignalHistory shortened = EmptyHistory(p, history, work.border);
  if (!p.plan.runs.reproject) {
    return shortened;
  }
  p.stages.fetch_history(history.signals[signal], work.taps, &shortened);
  const Image1* limit = LimitOf(p, work, signal);
  for (int y = 0; limit != nullptr && y < history.height; ++y) {
    for (int x = 0; x < history.width; ++x) {
      const float most = (*limit)(x, y);
      if (most < shortened.length(x, y)) {
        shortened.length(x, y) = most;
        shortened.weights2(x, y) = std::max(shortened.weights2(x, y), 1.0f / most);
      }
    }
  }
  shortened.compressed = Image1();
  return shortened;
}

}  // namespace stillray
