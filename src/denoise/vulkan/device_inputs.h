// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Inputs of the filter from frames that a renderer left on the device.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "denoise/vulkan/parameters.h"
#include "denoise/vulkan/pass_recorder.h"
#include "gpu/device_frame.h"

namespace stillray::vulkan {

FrameFacts FactsOf(const Frame& frame, const gpu::DeviceFrame& pixels);

/// \return kInvalidArgument if the frame's images have another size
Status CheckSize(const Frame& frame, const gpu::DeviceFrame& pixels);

/// The inputs common to gpu::FrameImages and VulkanFrame.
/// \param from  gpu::FrameImages or VulkanFrame
/// \param ref   returns the ImageRef of one of its images
template <typename Images, typename Ref>
FrameInputs CommonInputs(const Images& from, const Ref& ref) {
  FrameInputs in;
  for (size_t k = 0; k < kSignalKindCount; ++k) {
    in.lights[k] = ref(from.lights[k]);
    in.second_moments[k] = ref(from.second_moments[k]);
  }
  in.depth = ref(from.depth);
  in.normal = ref(from.normal);
  in.id = ref(from.id);
  in.motion = ref(from.motion);
  in.albedos[0] = ref(from.albedo);
  in.albedos[1] = ref(from.specular_albedo);
  in.albedos[2] = ref(from.transmission_albedo);
  in.emission = ref(from.emission);
  in.background = ref(from.background);
  in.samples = ref(from.samples);
  in.roughness = ref(from.roughness);
  in.previous_normal = ref(from.previous_normal);
  return in;
}

/// All inputs, without outputs. Absent images have no view.
FrameInputs InputsOf(const gpu::DeviceFrame& pixels);

/// The view of one of stillray's own images; no view for nullptr.
ImageRef RefTo(const gpu::Image* image);

/// Tracks the images that descriptor sets were made for. A renderer may destroy images between two
/// frames, and new images may then have the old handles.
class SeenFrames {
 public:
  /// \param owners  of all images of the frame
  /// \return true if descriptor sets of earlier frames must be discarded before a set is made for
  ///     this frame
  bool Add(std::span<const std::shared_ptr<const void>> owners);

 private:
  std::vector<std::weak_ptr<const void>> seen_;
};

}  // namespace stillray::vulkan
