// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Names of the images and buffers of a filter, for schedules of frames.
#pragma once

#include <string>
#include <vector>

#include "stillray/vulkan.hpp"

namespace stillray::vulkan {

/// Names of a pipeline's images and buffers, by their number on the device.
struct ResourceNames {
  std::vector<std::string> images;
  std::vector<std::string> buffers;
};

/// Derived from pipelines with the denoiser's options, which create their resources in equal order.
Result<ResourceNames> NameResources(const VulkanOptions& options, uint32_t shared_memory);

}  // namespace stillray::vulkan
