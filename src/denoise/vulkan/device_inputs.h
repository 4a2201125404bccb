// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames that a renderer left on the device, as inputs of the filter.
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

/// All inputs; no output. Images that the frame lacks have no view.
FrameInputs InputsOf(const gpu::DeviceFrame& pixels);

/// The view of one of stillray's own images; none for nullptr.
ImageRef RefTo(const gpu::Image* image);

/// Remembers images that descriptor sets were made for. A renderer may destroy them between two
/// frames, and new ones then may have the same handles.
class SeenFrames {
 public:
  /// \param owners  of all images of the frame
  /// \return true if sets of earlier frames must be forgotten before one is made for this frame
  bool Add(std::span<const std::shared_ptr<const void>> owners);

 private:
  std::vector<std::weak_ptr<const void>> seen_;
};

}  // namespace stillray::vulkan
