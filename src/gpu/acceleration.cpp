// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/acceleration.h"

namespace stillray::gpu {

Result<Acceleration> Acceleration::Create(const DeviceContext* context, const Buffer& buffer,
                                          VkAccelerationStructureTypeKHR type) {
  Acceleration made;
  made.context_ = context;
  VkAccelerationStructureCreateInfoKHR create = {};
  create.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR;
  create.buffer = buffer.buffer;
  create.size = buffer.size;
  create.type = type;
  STILLRAY_RETURN_IF_ERROR(ToStatus(
      context->vk.CreateAccelerationStructureKHR(context->device, &create, nullptr, &made.handle_),
      "creating an acceleration structure"));
  VkAccelerationStructureDeviceAddressInfoKHR address = {};
  address.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR;
  address.accelerationStructure = made.handle_;
  made.address_ = context->vk.GetAccelerationStructureDeviceAddressKHR(context->device, &address);
  return made;
}

Acceleration& Acceleration::operator=(Acceleration&& other) noexcept {
  std::swap(context_, other.context_);
  std::swap(handle_, other.handle_);
  std::swap(address_, other.address_);
  return *this;
}

Acceleration::~Acceleration() {
  if (context_ != nullptr) {
    context_->vk.DestroyAccelerationStructureKHR(context_->device, handle_, nullptr);
  }
}

void WaitForBuilds(const DeviceContext& context, VkCommandBuffer commands) {
  MemoryBarrier(context, commands, VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
                VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR |
                    VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR);
}

}  // namespace stillray::gpu
