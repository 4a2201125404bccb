// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A Vulkan acceleration structure in a buffer.
#pragma once

#include <utility>

#include "gpu/memory.h"

namespace stillray::gpu {

/// Move-only; the buffer must outlive the acceleration structure.
class Acceleration {
 public:
  /// Required usage flags of the buffer.
  static constexpr VkBufferUsageFlags kUsage =
      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR |
      VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

  /// Creates a structure that occupies the whole buffer; does not build it.
  static Result<Acceleration> Create(const DeviceContext* context, const Buffer& buffer,
                                     VkAccelerationStructureTypeKHR type);
  Acceleration() = default;
  Acceleration(Acceleration&& other) noexcept { *this = std::move(other); }
  Acceleration& operator=(Acceleration&& other) noexcept;
  ~Acceleration();

  const VkAccelerationStructureKHR& handle() const { return handle_; }
  VkDeviceAddress address() const { return address_; }

 private:
  const DeviceContext* context_ = nullptr;
  VkAccelerationStructureKHR handle_ = VK_NULL_HANDLE;
  VkDeviceAddress address_ = 0;
};

/// Records a barrier that makes earlier builds and copies visible to later builds, copies and
/// queries.
void WaitForBuilds(const DeviceContext& context, VkCommandBuffer commands);

}  // namespace stillray::gpu
