// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A frame on the device, as a renderer passes it to its denoiser.
#pragma once

#include "gpu/device_frame.h"
#include "stillray/vulkan.hpp"

namespace stillray::test {

/// The images of a frame that lies on the device, without the result; of those that may lack, those
/// that `f` has.
/// \param view  VulkanImage of a gpu::Image
template <typename View>
VulkanFrame EmbeddedFrame(const Frame& f, const gpu::DeviceFrame& pixels, const View& view) {
  const gpu::FrameImages& from = pixels.images();
  const auto image = [&](const gpu::Image* i, bool given = true) {
    return given && i != nullptr ? view(*i) : VulkanImage();
  };
  VulkanFrame out;
  out.index = f.index;
  out.jitter_x = f.jitter_x;
  out.jitter_y = f.jitter_y;
  out.focal_pixels = f.focal_pixels;
  out.samples_per_pixel = pixels.samples_per_pixel;
  for (size_t k = 0; k < pixels.lights().size(); ++k) {
    out.lights[k] = image(from.lights[k]);
    out.second_moments[k] = image(from.second_moments[k]);
  }
  out.depth = image(from.depth);
  out.normal = image(from.normal);
  out.id = image(from.id, !f.guides.id.empty());
  out.motion = image(from.motion);
  out.albedo = image(from.albedo);
  out.specular_albedo = image(from.specular_albedo);
  out.transmission_albedo = image(from.transmission_albedo);
  out.emission = image(from.emission, !f.emission.empty());
  out.background = image(from.background, !f.background.empty());
  out.samples = image(from.samples, !f.samples.empty());
  out.roughness = image(from.roughness);
  out.previous_normal = image(from.previous_normal, !f.guides.previous_normal.empty());
  const auto seen = [&](const gpu::VirtualImages& images, const VirtualGuides& guides) {
    const bool given = !guides.empty();
    return VulkanVirtualGuides{image(images.depth, given), image(images.normal, given),
                               image(images.motion, given), image(images.id, !guides.id.empty()),
                               image(images.albedo, given)};
  };
  out.reflection = seen(from.reflection, f.reflection);
  out.refraction = seen(from.refraction, f.refraction);
  return out;
}

}  // namespace stillray::test
