// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/parameters.h"

#include "core/check.h"
#include "core/negative_limit.h"

namespace stillray::vulkan {
namespace {

int LightMask(const SignalGroup& group) {
  int mask = 0;
  for (const SignalKind kind : group.kinds) {
    mask |= 1 << static_cast<int>(kind);
  }
  return mask;
}

int AlbedoMask(const SignalGroup& group) {
  return (group.diffuse_albedo ? 1 : 0) | (group.specular_albedo ? 2 : 0) |
         (group.transmission_albedo ? 4 : 0);
}

void SetSignals(const FramePlan& plan, FrameParameters* p) {
  int light_masks[kMostGroups] = {};
  int albedo_masks[kMostGroups] = {};
  for (size_t i = 0; i < plan.signals.size(); ++i) {
    const int channel = plan.signals[i].channel;
    STILLRAY_CHECK(channel < 0 || static_cast<size_t>(channel) == i);
    p->by_channel = channel < 0 ? 0 : 1;
    light_masks[i] = LightMask(plan.signals[i]);
    albedo_masks[i] = AlbedoMask(plan.signals[i]);
  }
  p->lights_of_0 = light_masks[0];
  p->lights_of_1 = light_masks[1];
  p->lights_of_2 = light_masks[2];
  p->lights_of_3 = light_masks[3];
  p->albedos_of_0 = albedo_masks[0];
  p->albedos_of_1 = albedo_masks[1];
  p->albedos_of_2 = albedo_masks[2];
  p->albedos_of_3 = albedo_masks[3];
}

void SetInput(const FrameFacts& facts, FrameParameters* p) {
  p->lights = static_cast<int>(facts.lights & ~facts.black_lights);
  p->second_moments = static_cast<int>(facts.second_moments);
  p->own_albedos = static_cast<int>(facts.albedos);
  p->has_samples = facts.has_samples ? 1 : 0;
  p->has_id = facts.has_id ? 1 : 0;
  p->has_emission = facts.has_emission ? 1 : 0;
  p->has_background = facts.has_background ? 1 : 0;
  p->has_confidence = facts.has_confidence ? 1 : 0;
  p->has_previous_normal = facts.has_previous_normal ? 1 : 0;
}

}  // namespace

Shape ShapeOf(const Settings& settings, int width, int height, int signals, Storage storage) {
  const HistoryLayout layout = LayoutOf(settings);
  Shape shape;
  shape.width = width;
  shape.height = height;
  shape.signals = signals;
  shape.with_compressed = layout.with_compressed;
  shape.with_coarse = settings.limit_history || RestoresEnergy(settings);
  shape.with_behind = layout.with_behind;
  shape.clamps_fireflies = settings.firefly == Firefly::kClamp;
  shape.luminance_factors = settings.wavelet == Wavelet::kSvgf;
  shape.with_albedo = KeepsAlbedo(settings);
  shape.storage = storage;
  shape.octahedral = PacksNormals(settings.normals, PacksNormalsByDefault(storage));
  return shape;
}

FrameParameters MakeParameters(const FramePlan& plan, const FrameFacts& facts, const Shape& shape) {
  FrameParameters p = {};
  p.width = shape.width;
  p.height = shape.height;
  p.signals = shape.signals;
  SetInput(facts, &p);
  SetSignals(plan, &p);
  p.albedos = plan.demodulate.demodulate != 0 ? p.own_albedos : 0;
  p.measure_stride = MeasureStride(shape.width, shape.height, plan.is_sparse);
  p.has_history = plan.runs.reproject ? 1 : 0;
  p.has_picture = plan.has_picture ? 1 : 0;
  p.with_compressed = shape.with_compressed ? 1 : 0;
  p.with_behind = shape.with_behind ? 1 : 0;
  p.feedback_phase = plan.feedback_phase;
  p.estimates_variance = plan.runs.estimate_variance ? 1 : 0;
  p.keeps_length = facts.keeps_length ? 1 : 0;
  p.shows = plan.runs.tonemap ? 1 : 0;
  p.restore_energy = plan.restore_energy;
  p.demodulate = plan.demodulate;
  p.reproject = plan.reproject;
  p.limit_history = plan.limit_history;
  p.compared = plan.compared;
  p.accumulate = plan.accumulate;
  p.estimate_variance = plan.estimate_variance;
  p.prefilter_variance = plan.prefilter_variance;
  p.atrous = plan.atrous;
  p.clip_outliers = plan.clip_outliers;
  p.keep_samples = plan.keep_samples;
  p.keep_mirrors = plan.keep_mirrors;
  p.fxaa = plan.fxaa;
  p.antialias = plan.antialias;
  p.tonemap = plan.tonemap;
  return p;
}

}  // namespace stillray::vulkan
