// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/parameters.h"

#include <algorithm>
#include <cmath>

#include "core/negative_limit.h"
#include "denoise/denoiser_impl.h"
#include "denoise/filter_parameters.h"

namespace stillray::vulkan {
namespace {

int LightMask(const SignalGroup& group) {
  int mask = 0;
  for (const SignalKind kind : group.kinds) {
    mask |= 1 << static_cast<int>(kind);
  }
  return mask;
}

/// Signals of light that was mirrored or refracted.
int MirrorMask(std::span<const SignalGroup> groups, const FrameFacts& facts) {
  int mask = 0;
  for (size_t i = 0; i < groups.size(); ++i) {
    for (const SignalKind kind : groups[i].kinds) {
      const bool given = (facts.lights >> static_cast<uint32_t>(kind) & 1u) != 0;
      mask |= given && IsSharpAtMirrors(kind) ? 1 << i : 0;
    }
  }
  return mask;
}

int AlbedoMask(const SignalGroup& group) {
  return (group.diffuse_albedo ? 1 : 0) | (group.specular_albedo ? 2 : 0) |
         (group.transmission_albedo ? 4 : 0);
}

void SetInput(const Settings& s, std::span<const SignalGroup> groups, const FrameFacts& facts,
              FrameParameters* p) {
  int light_masks[kMostGroups] = {};
  int albedo_masks[kMostGroups] = {};
  for (size_t i = 0; i < groups.size(); ++i) {
    light_masks[i] = LightMask(groups[i]);
    albedo_masks[i] = AlbedoMask(groups[i]);
  }
  p->lights = static_cast<int>(facts.lights);
  p->second_moments = static_cast<int>(facts.second_moments);
  p->own_albedos = static_cast<int>(facts.albedos);
  p->albedos = s.demodulate ? p->own_albedos : 0;
  p->lights_of_0 = light_masks[0];
  p->lights_of_1 = light_masks[1];
  p->lights_of_2 = light_masks[2];
  p->lights_of_3 = light_masks[3];
  p->albedos_of_0 = albedo_masks[0];
  p->albedos_of_1 = albedo_masks[1];
  p->albedos_of_2 = albedo_masks[2];
  p->albedos_of_3 = albedo_masks[3];
  p->has_samples = facts.has_samples ? 1 : 0;
  p->has_id = facts.has_id ? 1 : 0;
  p->has_emission = facts.has_emission ? 1 : 0;
  p->has_background = facts.has_background ? 1 : 0;
  p->rec601 = s.luminance == LuminanceWeights::kRec601 ? 1 : 0;
  p->firefly = static_cast<int>(s.firefly);
  p->frame = static_cast<uint32_t>(facts.index);
  p->colour_is_half = facts.colour_is_half ? 1 : 0;
  p->shows = facts.shows ? 1 : 0;
}

void SetTemporal(const Settings& s, FrameParameters* p) {
  p->depth_tolerance = s.history_depth;
  p->min_cosine = std::cos(s.history_normal * 0.017453293f);
  p->test_id = s.history_id ? 1 : 0;
  p->search = s.history_search ? 1 : 0;
  p->alpha_min = s.alpha_min;
  p->alpha_moments = s.alpha_moments;
  p->constant_weight = s.history_weight == HistoryWeight::kConstant ? 1 : 0;
  p->max_history = s.max_history;
  p->dead = s.limit_dead;
  p->gain = s.limit_gain;
}

void SetWavelet(const Settings& s, bool sparse, FrameParameters* p) {
  p->estimate = s.wavelet == Wavelet::kSvgf ? 1 : 0;
  p->of_mean = s.variance_of == VarianceOf::kMean ? 1 : 0;
  p->spatial = s.short_history == ShortHistory::kSpatial ? 1 : 0;
  p->short_length = ShortHistoryLength(s);
  p->least_evidence = sparse ? kLeastEvidence : 0.0f;
  p->boost = s.short_history_boost;
  p->smooth_variance = s.prefilter_variance ? 1 : 0;
  p->square_root = s.luminance_scale == LuminanceScale::kDeviation ? 1 : 0;
  p->sigma_l = s.sigma_l;
  p->luminance_epsilon = s.luminance_epsilon;
  p->unbounded_below = s.short_history == ShortHistory::kBlur ? ShortHistoryLength(s) : 0.0f;
  p->sigma_n = s.sigma_n;
  p->plane = s.depth_weight == DepthWeight::kPlane ? 1 : 0;
  p->sigma_z = s.sigma_z;
  p->plane_tolerance = s.plane_tolerance;
  p->depth_epsilon = s.depth_epsilon;
  p->max_slope = s.max_slope;
  p->wavelet_id = s.wavelet_id ? 1 : 0;
  p->noise_ratio = s.noise_ratio;
  p->eaw_sigma_l = s.eaw_sigma_l;
  p->eaw_sigma_n = s.eaw_sigma_n;
  p->eaw_sigma_z = s.eaw_sigma_z;
  p->grows = sparse ? 1 : 0;
}

void SetPicture(const Settings& s, const FrameFacts& facts, FrameParameters* p) {
  p->taa_alpha = s.taa_alpha;
  p->weigh_by_length = s.temporal ? 1 : 0;
  p->fxaa_by_length = s.fxaa == Fxaa::kSparse ? 1 : 0;
  p->display_scale = std::exp2(s.exposure);
  p->curve = static_cast<int>(s.tonemap);
  p->dither = s.dither;
  p->frame = static_cast<uint32_t>(facts.index);
}

}  // namespace

void AdvanceFeedback(const Settings& settings, float samples_per_pixel, Progress* progress) {
  progress->sparse = samples_per_pixel < kWholeSample;
  progress->feedback_progress =
      std::min(progress->feedback_progress + std::min(samples_per_pixel, 1.0f), 1.0f);
  const bool whole = progress->feedback_progress > kWholeSample;
  progress->feedback_phase = whole ? 1.0f : progress->feedback_progress;
  progress->feeds_back = settings.temporal && settings.feedback > 0 &&
                         (settings.feedback_when == FeedbackWhen::kFrame || whole);
  if (whole) {
    progress->feedback_progress = 0;
  }
}

Shape ShapeOf(const Settings& settings, int width, int height, int signals, Storage storage) {
  Shape shape;
  shape.width = width;
  shape.height = height;
  shape.signals = signals;
  shape.with_compressed = settings.limit_history;
  shape.with_behind = BlendsFeedback(settings);
  shape.clamps_fireflies = settings.firefly == Firefly::kClamp;
  shape.stops = settings.wavelet == Wavelet::kSvgf;
  shape.storage = storage;
  return shape;
}

FrameParameters MakeParameters(const Settings& settings, std::span<const SignalGroup> groups,
                               const Shape& shape, const FrameFacts& facts,
                               const Progress& progress) {
  FrameParameters p = {};
  p.width = shape.width;
  p.height = shape.height;
  p.signals = shape.signals;
  SetInput(settings, groups, facts, &p);
  p.measure_stride = MeasureStride(shape.width, shape.height, progress.sparse);
  p.has_history = progress.has_history && settings.temporal ? 1 : 0;
  p.has_picture = progress.has_picture && AntialiasesInTime(settings, progress.jittered) ? 1 : 0;
  p.with_compressed = shape.with_compressed ? 1 : 0;
  p.with_behind = shape.with_behind ? 1 : 0;
  p.feedback_phase = progress.feedback_phase;
  SetTemporal(settings, &p);
  SetWavelet(settings, progress.sparse, &p);
  p.mirror_signals = facts.has_roughness ? MirrorMask(groups, facts) : 0;
  p.mirror_roughness = settings.mirror_roughness;
  SetPicture(settings, facts, &p);
  return p;
}

}  // namespace stillray::vulkan
