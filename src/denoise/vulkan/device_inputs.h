// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames that a renderer left on the device, as inputs of the filter.
#pragma once

#include <memory>
#include <vector>

#include "denoise/vulkan/parameters.h"
#include "denoise/vulkan/pass_recorder.h"
#include "gpu/device_frame.h"

namespace stillray::vulkan {

FrameFacts FactsOf(const Frame& frame, const gpu::DeviceFrame& pixels);

/// All inputs; no output.
FrameInputs InputsOf(const gpu::DeviceFrame& pixels);

/// Remembers images that descriptor sets were made for. A renderer may destroy them between two
/// frames, and new ones then may have the same handles.
class SeenFrames {
 public:
  /// \return true if sets of earlier frames must be forgotten before one is made for this frame
  bool Add(const std::shared_ptr<FrameOnDevice>& pixels);

 private:
  std::vector<std::weak_ptr<FrameOnDevice>> seen_;
};

}  // namespace stillray::vulkan
