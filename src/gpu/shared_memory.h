// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Device memory exported to other APIs on the same device, such as OpenGL
/// (GL_EXT_memory_object_fd): its requirements (VK_KHR_external_memory_fd), and buffers in
/// exportable memory.
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

/// Queries the support of a device; empty without support, or if the device shares only dedicated
/// memory, which no driver requires for buffers. Never fails.
MemorySharing FindMemorySharing(const InstanceFunctions& functions, VkPhysicalDevice device);

/// A copy destination with its own exportable allocation.
class SharedBuffer {
 public:
  /// \return kUnsupported if the device does not share memory; kOutOfMemory
  static Result<std::unique_ptr<SharedBuffer>> Create(const DeviceContext* context,
                                                      VkDeviceSize bytes);
  SharedBuffer(const SharedBuffer&) = delete;
  SharedBuffer& operator=(const SharedBuffer&) = delete;
  ~SharedBuffer();

  VkBuffer buffer() const { return buffer_; }
  /// Size of the memory, required by importers; larger than the buffer.
  VkDeviceSize memory_bytes() const { return memory_bytes_; }
  /// Returns a new file descriptor of the memory; the memory lives as long as any import. The
  /// caller closes the descriptor, or passes it to an importer.
  Result<int> Export() const;

 private:
  explicit SharedBuffer(const DeviceContext* context) : context_(context) {}
  Status Make(VkDeviceSize bytes);

  const DeviceContext* context_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  VkDeviceSize memory_bytes_ = 0;
};

/// Records the queue family ownership release of the buffer to other APIs.
void RecordRelease(const DeviceContext& context, VkCommandBuffer commands, uint32_t queue_family,
                   const SharedBuffer& buffer);

}  // namespace stillray::gpu
