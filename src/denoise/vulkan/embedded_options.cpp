// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/vulkan/embedded_options.h"

namespace stillray::vulkan {

PipelineOptions PipelineOptionsOf(const VulkanOptions& o) {
  PipelineOptions options;
  options.settings = o.settings;
  options.width = o.width;
  options.height = o.height;
  options.transmission = o.transmission;
  options.storage = o.precision == DevicePrecision::kFloat ? Storage::kFloat : Storage::kHalf;
  options.timed = o.timestamps;
  options.fills_guides = o.incomplete_guides;
  options.in_flight = static_cast<uint32_t>(o.frames_in_flight);
  return options;
}

PipelineOptions LayerOptionsOf(const VulkanOptions& o, GuideSource source) {
  PipelineOptions options = PipelineOptionsOf(o);
  options.settings = SettingsOfLayer(o.settings);
  options.transmission = source == GuideSource::kRefraction;
  return options;
}

LayerShape LayerShapeOf(const VulkanOptions& o, GuideSource source) {
  return {.width = o.width,
          .height = o.height,
          .previous_normals = true,
          .second_moments = true,
          .with_picture = true,
          .with_hits = o.hit_distances && source == GuideSource::kReflection};
}

}  // namespace stillray::vulkan
