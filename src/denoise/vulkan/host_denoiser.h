// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A Denoiser on a Vulkan device for frames in host memory, and for those left on the device.
#pragma once

#include <memory>

#include "denoise/backend.h"
#include "gpu/device.h"

namespace stillray::vulkan {

class VulkanBackend : public DeviceBackend {
 public:
  explicit VulkanBackend(std::shared_ptr<gpu::Device> device) : device_(std::move(device)) {}
  Result<std::unique_ptr<DenoiserBackend>> CreateDenoiser(const Settings& settings,
                                                          DevicePrecision precision) override;
  bool Holds(const Frame& frame) const override;
  Result<std::unique_ptr<FrameSplit>> CreateFrameSplit() override;
  const std::shared_ptr<gpu::Device>& device() const { return device_; }

 private:
  std::shared_ptr<gpu::Device> device_;
};

}  // namespace stillray::vulkan
