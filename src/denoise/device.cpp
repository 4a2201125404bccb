// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "denoise/backend.h"

namespace stillray {

Device::Device() : impl_(std::make_shared<Impl>(Impl{"cpu", {}, nullptr, false})) {}

Device MakeDevice(std::shared_ptr<DeviceBackend> backend, std::string description) {
  Device device;
  device.impl_->backend = std::move(backend);
  device.impl_->description = std::move(description);
  return device;
}

std::shared_ptr<DeviceBackend> BackendOf(const Device& device) {
  return device.impl_->backend;
}

bool Device::is_cpu() const {
  return impl_->backend == nullptr;
}

const std::string& Device::description() const {
  return impl_->description;
}

const std::string& Device::remark() const {
  return impl_->remark;
}

}  // namespace stillray
