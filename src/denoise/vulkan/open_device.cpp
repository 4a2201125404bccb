// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include "denoise/vulkan/host_denoiser.h"

namespace stillray {
namespace {

std::string Describe(const gpu::DeviceInfo& info) {
  return fmt::format("vulkan:{}: {} ({}), {}, Vulkan {}.{}, {:.1f} GB", info.index, info.name,
                     info.kind, info.driver, VK_API_VERSION_MAJOR(info.api_version),
                     VK_API_VERSION_MINOR(info.api_version),
                     static_cast<double>(info.memory_bytes) / 1e9);
}

/// All devices of one instance.
struct Found {
  std::shared_ptr<gpu::Instance> instance;
  std::vector<gpu::DeviceInfo> devices;
};

Result<Found> FindDevices() {
  Result<std::shared_ptr<gpu::Instance>> instance = gpu::Instance::Create();
  STILLRAY_RETURN_IF_ERROR(instance.status());
  Result<std::vector<gpu::DeviceInfo>> devices = (*instance)->ListDevices();
  STILLRAY_RETURN_IF_ERROR(devices.status());
  return Found{*instance, std::move(devices.value())};
}

}  // namespace

/// Opens a usable GPU, else the CPU, with the reason as remark.
Result<Device> Device::OpenBest() {
  Device cpu;
  const Result<Found> found = FindDevices();
  if (!found.ok()) {
    cpu.impl_->remark = found.status().message();
    return cpu;
  }
  const Result<gpu::DeviceInfo> chosen = gpu::ChooseDevice(found->devices, "vulkan");
  if (!chosen.ok()) {
    cpu.impl_->remark = chosen.status().message();
    return cpu;
  }
  if (!chosen->is_gpu) {
    cpu.impl_->remark = fmt::format("Vulkan offers only {} ({})", chosen->name, chosen->kind);
    return cpu;
  }
  Result<Device> opened = Open(fmt::format("vulkan:{}", chosen->index));
  if (!opened.ok()) {
    cpu.impl_->remark = opened.status().message();
    return cpu;
  }
  opened->impl_->may_fall_back = true;
  return opened;
}

namespace {

Result<std::shared_ptr<gpu::Device>> OpenVulkan(const std::string& choice) {
  const Result<gpu::DeviceInfo> understood = gpu::ChooseDevice({gpu::DeviceInfo()}, choice);
  if (!understood.ok() && understood.status().code() == StatusCode::kInvalidArgument) {
    return understood.status();
  }
  const Result<Found> found = FindDevices();
  STILLRAY_RETURN_IF_ERROR(found.status());
  const Result<gpu::DeviceInfo> chosen = gpu::ChooseDevice(found->devices, choice);
  STILLRAY_RETURN_IF_ERROR(chosen.status());
  return gpu::Device::Create(found->instance, *chosen);
}

}  // namespace

Result<Device> Device::Open(const std::string& choice) {
  if (choice == "cpu") {
    return Device();
  }
  if (choice == "auto") {
    return OpenBest();
  }
  const Result<std::shared_ptr<gpu::Device>> made = OpenVulkan(choice);
  STILLRAY_RETURN_IF_ERROR(made.status());
  return MakeDevice(std::make_shared<vulkan::VulkanBackend>(*made), Describe((*made)->info()));
}

std::vector<DeviceDescription> ListDevices(std::string* remark) {
  std::vector<DeviceDescription> list;
  const Result<Found> found = FindDevices();
  if (!found.ok()) {
    *remark = found.status().message();
    return list;
  }
  for (const gpu::DeviceInfo& info : found->devices) {
    list.push_back({fmt::format("vulkan:{}", info.index), info.name, info.kind, info.driver,
                    info.memory_bytes, info.is_gpu, info.usable});
  }
  return list;
}

}  // namespace stillray
