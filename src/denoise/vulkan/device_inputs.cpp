// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/device_inputs.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace stillray::vulkan {
namespace {

/// Renderers use one frame or alternate between two. Caching sets for more is not worth the memory.
constexpr size_t kMostSeen = 4;

}  // namespace

ImageRef RefTo(const gpu::Image* image) {
  return {image != nullptr ? image->view : VK_NULL_HANDLE, VK_IMAGE_LAYOUT_GENERAL};
}

FrameFacts FactsOf(const Frame& frame, const gpu::DeviceFrame& pixels) {
  const uint32_t lights = (1u << pixels.lights().size()) - 1;
  FrameFacts facts;
  facts.index = frame.index;
  facts.width = frame.width;
  facts.height = frame.height;
  facts.focal_pixels = frame.focal_pixels;
  facts.jitter_x = frame.jitter_x;
  facts.jitter_y = frame.jitter_y;
  facts.lights = lights;
  facts.second_moments = pixels.shape().second_moments ? lights : 0;
  facts.albedos = 1u << 0 | 1u << 1 | (pixels.shape().transmission ? 1u << 2 : 0u);
  facts.has_samples = pixels.shape().samples;
  facts.has_id = true;
  facts.has_emission = true;
  facts.has_background = true;
  facts.has_roughness = true;
  facts.has_previous_normal = pixels.shape().previous_normals;
  facts.samples_per_pixel = pixels.samples_per_pixel;
  facts.has_incomplete_guides = pixels.has_incomplete_guides;
  return facts;
}

Status CheckSize(const Frame& frame, const gpu::DeviceFrame& pixels) {
  const gpu::FrameShape& shape = pixels.shape();
  return frame.width == shape.width && frame.height == shape.height
             ? Status::Ok()
             : Status::InvalidArgument(
                   fmt::format("frame {}: size is {}x{}, its images on the device are {}x{}",
                               frame.index, frame.width, frame.height, shape.width, shape.height));
}

FrameInputs InputsOf(const gpu::DeviceFrame& pixels) {
  return CommonInputs(pixels.images(), RefTo);
}

bool SeenFrames::Add(std::span<const std::shared_ptr<const void>> owners) {
  const auto is_new = [&](const std::shared_ptr<const void>& owner) {
    return std::none_of(seen_.begin(), seen_.end(),
                        [&](const auto& seen) { return seen.lock() == owner; });
  };
  const auto added = std::count_if(owners.begin(), owners.end(), is_new);
  const bool any_gone =
      std::any_of(seen_.begin(), seen_.end(), [](const auto& seen) { return seen.expired(); });
  const bool forgets = any_gone || (added > 0 && seen_.size() >= kMostSeen);
  if (forgets) {
    seen_.clear();
  }
  std::copy_if(owners.begin(), owners.end(), std::back_inserter(seen_), is_new);
  return forgets;
}

}  // namespace stillray::vulkan
