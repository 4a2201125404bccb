// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Devices of a build without Vulkan, which has only the CPU.
#include <fmt/format.h>

#include "core/device_choice.h"
#include "denoise/backend.h"

namespace stillray {
namespace {

constexpr const char* kWithoutVulkan =
    "this stillray was built without Vulkan (its headers or glslc were missing, or "
    "STILLRAY_BUILD_VULKAN was off)";

}  // namespace

Result<Device> Device::OpenBest() {
  return Device();
}

Result<Device> Device::Open(const std::string& choice) {
  if (choice == "cpu" || choice == "auto") {
    return Device();
  }
  if (choice.compare(0, 6, "vulkan") == 0) {
    return Status::Unsupported(kWithoutVulkan);
  }
  return UnknownDeviceChoice(choice);
}

std::vector<DeviceDescription> ListDevices(std::string* remark) {
  *remark = kWithoutVulkan;
  return {};
}

}  // namespace stillray
