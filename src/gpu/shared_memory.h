// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Device memory that other APIs on the same device can import, as OpenGL does with
/// GL_EXT_memory_object_fd: its requirements (VK_KHR_external_memory_fd), and buffers in such
/// memory.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "gpu/functions.h"

namespace stillray::gpu {

struct DeviceContext;

/// Extensions to enable on a device for sharing memory, beside Vulkan 1.1.
inline constexpr std::array kSharingExtensions = {VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME};

using Uuid = std::array<uint8_t, VK_UUID_SIZE>;

struct MemorySharing {
  bool offered = false;
  /// Identifies the device and the driver to other APIs.
  Uuid device = {};
  Uuid driver = {};
};

/// Never fails: a device without support yields an empty result. So does one that shares only
/// dedicated memory, which no driver does for buffers.
MemorySharing FindMemorySharing(const InstanceFunctions& functions, VkPhysicalDevice device);

/// A copy destination in memory of its own.
class SharedBuffer {
 public:
  /// \return kUnsupported if the device does not share memory; kOutOfMemory
  static Result<std::unique_ptr<SharedBuffer>> Create(const DeviceContext* context,
                                                      VkDeviceSize bytes);
  SharedBuffer(const SharedBuffer&) = delete;
  SharedBuffer& operator=(const SharedBuffer&) = delete;
  ~SharedBuffer();

  VkBuffer buffer() const { return buffer_; }
  /// Size of the memory, which importers need; larger than the buffer.
  VkDeviceSize memory_bytes() const { return memory_bytes_; }
  /// A new file descriptor of the memory, which lives as long as any import of it. The caller
  /// closes it, or passes it to an importer.
  Result<int> Export() const;

 private:
  explicit SharedBuffer(const DeviceContext* context) : context_(context) {}
  Status Make(VkDeviceSize bytes);

  const DeviceContext* context_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize memory_bytes_ = 0;
};

/// Records the release of the buffer's content from the queue's family to other APIs.
void RecordRelease(const DeviceContext& context, VkCommandBuffer commands, uint32_t queue_family,
                   const SharedBuffer& buffer);

}  // namespace stillray::gpu
