// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/extensions.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace stillray::gpu {

bool HasExtensions(const InstanceFunctions& vk, VkPhysicalDevice device,
                   std::span<const char* const> wanted) {
  uint32_t count = 0;
  if (vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr) != VK_SUCCESS) {
    return false;
  }
  std::vector<VkExtensionProperties> offered(count);
  if (vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, offered.data()) !=
      VK_SUCCESS) {
    return false;
  }
  offered.resize(count);
  return std::all_of(wanted.begin(), wanted.end(), [&](const char* name) {
    return std::any_of(offered.begin(), offered.end(), [&](const VkExtensionProperties& e) {
      return std::strcmp(e.extensionName, name) == 0;
    });
  });
}

}  // namespace stillray::gpu
