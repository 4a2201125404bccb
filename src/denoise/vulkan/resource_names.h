// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Names of the images and buffers of a filter, for schedules of frames.
#pragma once

#include <string>
#include <vector>

#include "denoise/shader_pack.h"

namespace stillray::vulkan {

/// Names of a pipeline's images and buffers, by their number on the device.
struct ResourceNames {
  std::vector<std::string> images;
  std::vector<std::string> buffers;
};

/// From a pipeline like that of the denoiser, which creates them in the same order.
/// \param transmission  frames have transmission signals
Result<ResourceNames> NameResources(const ScheduleOptions& options, bool transmission);

}  // namespace stillray::vulkan
