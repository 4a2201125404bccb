// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/wavelet.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/parallel.h"
#include "denoise/copy_image.h"
#include "denoise/level_names.h"
#include "denoise/row_sums.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

/// Whether every surface has samples.
bool IsComplete(const Image1& valid, const GuidePlanes& guides) {
  std::atomic<bool> all_valid = true;
  ParallelRows(valid.height(), 32, [&](int y0, int y1) {
    if (!all_valid) {
      return;  // known from another band
    }
    int missing = 0;
    for (int y = y0; y < y1; ++y) {
      const float* i = guides.inverse_depth.Row(y);
      const float* there = valid.Row(y);
      for (int x = 0; x < valid.width(); ++x) {
        missing += i[x] > 0 && there[x] == 0 ? 1 : 0;
      }
    }
    if (missing > 0) {
      all_valid = false;
    }
  });
  return all_valid;
}

/// Blends the history before the last feedback with the history after it (PSVGF section 5).
void BlendFeedback(const SignalHistory& history, float phase, LumaImage3* out) {
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

/// Whether the weights of a level compare a pilot estimate of the signal.
bool HasPilot(const CpuPipeline& p, int level, size_t signal) {
  return level < kPilotLevels &&
         (p.plan.pilot_signals[static_cast<size_t>(level)] >> signal & 1) != 0;
}

/// Marks the surfaces with samples, unless all have some.
void FindPresent(const Image1& surface, WaveletPlanes* planes) {
  const Image1& length = planes->history->length;
  planes->where = planes->all_valid ? &surface : &planes->valid;
  if (planes->all_valid) {
    return;
  }
  ParallelRows(length.height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float* i = surface.Row(y);
      const float* samples = length.Row(y);
      float* to = planes->valid.Row(y);
      for (int x = 0; x < length.width(); ++x) {
        to[x] = i[x] > 0 && samples[x] > 0 ? 1.0f : 0.0f;
      }
    }
  });
}

void RunEstimateVariance(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                         LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "estimate_variance");
  std::array<VarianceSignal, kMostGroups> signals;
  const size_t count = p.plan.signals.size();
  for (size_t i = 0; i < count; ++i) {
    const WaveletPlanes& planes = work->wavelet[i];
    signals[i] = {planes.history, in.frame.samples.empty() ? nullptr : &work->light[i].samples,
                  planes.variance};
  }
  p.stages.estimate_variance({signals.data(), count}, guides, p.plan.estimate_variance);
  for (size_t i = 0; i < count; ++i) {
    work->wavelet[i].all_valid = signals[i].all_valid;
    outputs->KeepPlane("variance", p.plan.signals[i], *work->wavelet[i].variance);
  }
}

/// Smooths the variance that is the input of the first level.
void RunSmoothVariance(const CpuPipeline& p, const GuidePlanes& guides,
                       std::vector<WaveletPlanes>* wavelet, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "prefilter_variance");
  for (WaveletPlanes& planes : *wavelet) {
    Image1& smoothed = planes.filter[planes.target].variance;
    p.stages.smooth_variance(
        {planes.variance, planes.where, planes.all_valid ? &guides.full : nullptr}, &smoothed);
    std::swap(*planes.variance, smoothed);
  }
}

/// The confidence that widens the luminance weight of a signal (VolumeWidening); nullptr: not
/// widened.
const Image1* WideningConfidence(const CpuPipeline& p, const Frame& frame, size_t signal) {
  const bool widens = p.plan.prefilter_variance.volume_widening > 1 &&
                      (p.plan.prefilter_variance.volume_signals >> signal & 1) != 0;
  return widens && !frame.confidence.empty() ? &frame.confidence : nullptr;
}

/// \param pilot  for the pilot estimate instead of the signal
void RunPrefilterVariance(const CpuPipeline& p, const Frame& frame, const GuidePlanes& guides,
                          size_t signal, bool pilot, WaveletPlanes* planes, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "prefilter_variance");
  const Image1& luminance = pilot ? planes->pilot : (*planes->light)[0];
  const Image1& variance = pilot ? planes->filter[planes->target].variance : *planes->variance;
  const PrefilterVarianceInput in = {&luminance,
                                     &variance,
                                     planes->where,
                                     &planes->history->length,
                                     planes->all_valid ? &guides.full : nullptr,
                                     WideningConfidence(p, frame, signal)};
  p.stages.prefilter_variance(in, p.plan.prefilter_variance, &planes->luminance_factor);
}

/// The pilot estimate: the mean of 3x3 pixels on the same surface, as far apart as the taps of the
/// level. The weights of the first levels compare it in place of single pixels. The weights of a
/// pixel with few samples depend on its own noise: since radiance has a skewed distribution,
/// brighter neighbours are rejected more often than darker ones, and the image darkens. The
/// luminance is stored in `pilot`, its variance in the planes of the next level's output.
void RunPilot(const CpuPipeline& p, int level, const GuidePlanes& guides,
              std::vector<WaveletPlanes>* wavelet, DenoisedFrame* out) {
  std::array<WaveletPlanes*, kMostGroups> with_pilot;
  size_t count = 0;
  for (size_t i = 0; i < wavelet->size(); ++i) {
    if (HasPilot(p, level, i)) {
      with_pilot[count++] = &(*wavelet)[i];
    }
  }
  if (count == 0) {
    return;
  }
  const StageTimer timer(&out->timings, "pilot");
  std::array<AtrousSignal, kMostGroups> signals;
  for (size_t i = 0; i < count; ++i) {
    WaveletPlanes& planes = *with_pilot[i];
    signals[i] = {planes.light, planes.variance, &planes.filter[planes.target], nullptr,
                  planes.where};
    signals[i].all_valid = planes.all_valid;
    signals[i].luminance_only = true;
    if (p.fusion.mix_pilot && planes.all_valid) {
      signals[i].mixed_length = &planes.history->length;
      signals[i].mixed_full = p.plan.estimate_variance.short_history_length;
    }
  }
  p.stages.atrous({signals.data(), count}, guides, PilotLevel(level), p.plan.atrous);
  for (size_t i = 0; i < count; ++i) {
    WaveletPlanes& planes = *with_pilot[i];
    FilterPlanes& mean = planes.filter[planes.target];
    Image1& luminance = mean.colour[0];
    if (signals[i].mixed_length == nullptr) {
      p.stages.mix_pilot({&(*planes.light)[0], planes.variance, &planes.history->length},
                         p.plan.estimate_variance.short_history_length, &luminance, &mean.variance);
    }
    if (planes.pilot.empty()) {
      planes.pilot = Image1(luminance.width(), luminance.height(), luminance.border());
    }
    std::swap(luminance, planes.pilot);
  }
}

AtrousSignal SignalOf(const CpuPipeline& p, int level, size_t index, bool has_pilot,
                      WaveletPlanes* planes) {
  AtrousSignal signal = {planes->light, planes->variance, &planes->filter[planes->target],
                         p.plan.runs.estimate_variance ? &planes->luminance_factor : nullptr,
                         planes->where};
  signal.all_valid = planes->all_valid;
  signal.eaw_sigma_l =
      p.plan.atrous.eaw_sigma_l * planes->mean_luminance * std::exp2f(static_cast<float>(-level));
  signal.reflected = (p.plan.atrous.reflected_signals >> index & 1) != 0;
  signal.pilot = has_pilot ? &planes->pilot : nullptr;
  signal.valid_out = p.plan.atrous.grows != 0 && !planes->all_valid ? &planes->valid_out : nullptr;
  return signal;
}

/// Sets the output of a level as the input of the next one.
void FinishLevel(const AtrousSignal& signal, const GuidePlanes& guides, WaveletPlanes* planes) {
  FilterPlanes& filtered = planes->filter[planes->target];
  planes->light = &filtered.colour;
  planes->variance = &filtered.variance;
  planes->target ^= 1;
  if (signal.valid_out != nullptr) {
    std::swap(planes->valid, planes->valid_out);
    planes->all_valid = IsComplete(planes->valid, guides);
  }
}

/// Stores the output "smoothed_variance": the variance in the luminance weights of the first level.
void KeepSmoothedVariance(const CpuPipeline& p, const std::vector<WaveletPlanes>& wavelet,
                          FrameOutputs* outputs) {
  const int radius = p.plan.prefilter_variance.prefilter_variance != 0 ? 1 : 0;
  for (size_t i = 0; outputs->any() && i < wavelet.size(); ++i) {
    const Image1& variance = *wavelet[i].variance;
    const Image1& valid = *wavelet[i].where;
    Image1 smoothed(variance.width(), variance.height());
    for (int y = 0; y < smoothed.height(); ++y) {
      for (int x = 0; x < smoothed.width(); ++x) {
        smoothed(x, y) = valid(x, y) > 0 ? SmoothedVariance(variance, valid, radius, x, y) : 0.0f;
      }
    }
    outputs->KeepPlane("smoothed_variance", p.plan.signals[i], smoothed);
  }
}

/// Stores the outputs "weights1", ...: the sums of weights of each level.
void KeepWeights(const CpuPipeline& p, int level, const GuidePlanes& guides,
                 std::span<const AtrousSignal> signals, FrameOutputs* outputs) {
  const std::string kind = fmt::format("weights{}", level + 1);
  for (size_t i = 0; i < signals.size(); ++i) {
    const SignalGroup& group = p.plan.signals[i];
    if (outputs->Wants(fmt::format("{}.{}", kind, group.name))) {
      Image1 sums(signals[i].variance->width(), signals[i].variance->height());
      SumAtrousWeights(signals[i], guides, p.plan.level[static_cast<size_t>(level)], p.plan.atrous,
                       &sums);
      outputs->KeepPlane(kind.c_str(), group, sums);
    }
  }
}

void RunLevel(const CpuPipeline& p, const Frame& frame, int level, const GuidePlanes& guides,
              std::vector<WaveletPlanes>* wavelet, FrameOutputs* outputs, DenoisedFrame* out) {
  std::array<AtrousSignal, kMostGroups> signals;
  const size_t count = wavelet->size();
  RunPilot(p, level, guides, wavelet, out);
  for (size_t i = 0; i < count; ++i) {
    const bool has_pilot = HasPilot(p, level, i);
    if (p.plan.runs.estimate_variance) {
      RunPrefilterVariance(p, frame, guides, i, has_pilot, &(*wavelet)[i], out);
    }
    signals[i] = SignalOf(p, level, i, has_pilot, &(*wavelet)[i]);
  }
  if (outputs->any()) {
    KeepWeights(p, level, guides, {signals.data(), count}, outputs);
  }
  const StageTimer timer(&out->timings, LevelName(level));
  p.stages.atrous({signals.data(), count}, guides, p.plan.level[static_cast<size_t>(level)],
                  p.plan.atrous);
  for (size_t i = 0; i < count; ++i) {
    FinishLevel(signals[i], guides, &(*wavelet)[i]);
  }
}

/// The output of a level becomes the history of the next frame; the planes of the old history are
/// reused by later levels.
void FeedBack(WaveletPlanes* planes) {
  SignalHistory* history = planes->history;
  if (!history->behind.empty()) {
    std::swap(history->colour, history->behind);
  }
  std::swap(history->colour, *planes->light);
  planes->light = &history->colour;
}

void RunClipOutliers(const CpuPipeline& p, const GuidePlanes& guides,
                     std::vector<WaveletPlanes>* wavelet, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "clip_outliers");
  for (WaveletPlanes& planes : *wavelet) {
    LumaImage3* light = ChangeableLight(&planes);
    const ClipOutliersInput in = {planes.variance, planes.where,
                                  planes.all_valid ? &guides.full : nullptr};
    p.stages.clip_outliers(in, p.plan.clip_outliers, &planes.filter[planes.target], light);
  }
}

}  // namespace

LumaImage3* ChangeableLight(WaveletPlanes* planes) {
  if (planes->light == &planes->history->colour) {
    LumaImage3* room = &planes->filter[planes->target].colour;
    CopyImage(*planes->light, room);
    planes->light = room;
    planes->target ^= 1;
  }
  return planes->light;
}

void BeginFilter(const CpuPipeline& p, const FrameInput& in, size_t signal, SignalHistory* history,
                 LayerWork* work, FrameOutputs* outputs) {
  const SignalGroup& group = p.plan.signals[signal];
  outputs->KeepLight("accumulated", group, history->colour);
  outputs->KeepPlane("history", group, history->length);
  outputs->KeepPlane("moment_mean", group, history->mean);
  outputs->KeepPlane("moment_variance", group, history->variance);
  if (outputs->Wants("temporal")) {
    outputs->AddToPicture("temporal", history->colour,
                          AlbedosOf(p.plan.demodulate, group, in.guides), &work->scratch);
  }
  WaveletPlanes& planes = work->wavelet[signal];
  planes.history = history;
  planes.light = &history->colour;
  planes.variance = &planes.filter[0].variance;
  planes.target = 1;
  if (!p.plan.runs.wavelet) {
    return;
  }
  const Image1& valid = planes.valid;
  if (p.plan.atrous.grows != 0 &&
      (planes.valid_out.width() != valid.width() || planes.valid_out.height() != valid.height() ||
       planes.valid_out.border() != valid.border())) {
    planes.valid_out = Image1(valid.width(), valid.height(), valid.border());
  }
  if (p.plan.runs.measure_luminance) {
    planes.mean_luminance = MeanLuminance(history->colour, &work->row_sums);
  }
  if (p.plan.feedback_phase < 1 && !history->behind.empty()) {
    BlendFeedback(*history, p.plan.feedback_phase, &planes.filter[0].colour);
    planes.light = &planes.filter[0].colour;
  }
}

void RunWavelet(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out) {
  std::vector<WaveletPlanes>& wavelet = work->wavelet;
  if (p.plan.runs.estimate_variance) {
    RunEstimateVariance(p, in, guides, work, outputs, out);
  }
  for (WaveletPlanes& planes : wavelet) {
    if (!p.plan.runs.estimate_variance) {
      planes.all_valid = IsComplete(planes.history->length, guides);
    }
    FindPresent(guides.inverse_depth, &planes);
  }
  if (p.plan.runs.smooth_variance) {
    RunSmoothVariance(p, guides, &wavelet, out);
  }
  if (p.plan.runs.estimate_variance) {
    KeepSmoothedVariance(p, wavelet, outputs);
  }
  for (int level = 0; level < p.plan.levels; ++level) {
    RunLevel(p, in.frame, level, guides, &wavelet, outputs, out);
    const std::string name = outputs->any() ? fmt::format("atrous{}", level + 1) : "";
    for (size_t i = 0; i < wavelet.size(); ++i) {
      if (p.plan.feedback_level == level + 1) {
        FeedBack(&wavelet[i]);
      }
      if (outputs->Wants(name)) {
        outputs->AddToPicture(name, *wavelet[i].light,
                              AlbedosOf(p.plan.demodulate, p.plan.signals[i], in.guides),
                              &work->scratch);
      }
    }
  }
  for (size_t i = 0; i < wavelet.size(); ++i) {
    outputs->KeepPlane("filtered_variance", p.plan.signals[i], *wavelet[i].variance);
  }
  if (p.plan.runs.clip_outliers) {
    RunClipOutliers(p, guides, &wavelet, out);
  }
}

}  // namespace stillray
