// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Memory of a device that other APIs on the same device may import, as OpenGL does with
/// GL_EXT_memory_object_fd: what a device must offer for it (VK_KHR_external_memory_fd), and
/// buffers in such memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "gpu/functions.h"

namespace stillray::gpu {

struct DeviceContext;

/// What is enabled on a device that shares memory, beside Vulkan 1.1.
inline constexpr std::array kSharingExtensions = {VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME};

using Uuid = std::array<uint8_t, VK_UUID_SIZE>;

struct MemorySharing {
  bool offered = false;
  /// What other APIs know the same device and the same driver by.
  Uuid device = {};
  Uuid driver = {};
};

/// Never fails: a device without it offers nothing. Nor does one that shares dedicated memory
/// alone, which no driver does for buffers.
MemorySharing FindMemorySharing(const InstanceFunctions& functions, VkPhysicalDevice device);

/// A buffer that is copied to, in memory of its own.
class SharedBuffer {
 public:
  /// \return kUnsupported where the device does not share memory; kOutOfMemory
  static Result<std::unique_ptr<SharedBuffer>> Create(const DeviceContext* context,
                                                      VkDeviceSize bytes);
  SharedBuffer(const SharedBuffer&) = delete;
  SharedBuffer& operator=(const SharedBuffer&) = delete;
  ~SharedBuffer();

  VkBuffer buffer() const { return buffer_; }
  /// Of the memory, which importers ask for; more than of the buffer.
  VkDeviceSize memory_bytes() const { return memory_bytes_; }
  /// A new file descriptor of the memory, which lives as long as anyone who imported it. The
  /// caller's to close, or to give to who imports it.
  Result<int> Export() const;

 private:
  explicit SharedBuffer(const DeviceContext* context) : context_(context) {}
  Status Make(VkDeviceSize bytes);

  const DeviceContext* context_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize memory_bytes_ = 0;
};

/// Records that what was copied to the buffer is left to other APIs, from the queue's family.
void RecordRelease(const DeviceContext& context, VkCommandBuffer commands, uint32_t queue_family,
                   const SharedBuffer& buffer);

}  // namespace stillray::gpu
