// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Images and buffers of a device, in as few allocations as there are kinds of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "gpu/device.h"

namespace stillray::gpu {

/// An image of the arena. Valid as long as the arena is.
struct Image {
  VkImage image = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  VkFormat format = VK_FORMAT_UNDEFINED;
  int width = 0;
  int height = 0;
  int layers = 0;  ///< 0: a plain image, not an array of one
};

struct Buffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize size = 0;
  void* mapped = nullptr;       ///< of buffers that the host sees
  VkDeviceAddress address = 0;  ///< of buffers whose usage asks for one
};

/// Device memory of an arena.
struct MemoryUse {
  uint32_t allocations = 0;
  uint32_t resources = 0;  ///< images and buffers
  uint64_t bytes = 0;      ///< of all allocations
  uint64_t largest = 0;    ///< bytes of the largest image or buffer

  MemoryUse& operator+=(const MemoryUse& other);
};

enum class BufferPlace {
  kDevice,    ///< the device's own memory
  kUpload,    ///< written by the host, read by the device
  kDownload,  ///< written by the device, read by the host; cached if possible
};

/// Images and buffers are added first, then all memory is allocated at once, in one block per kind
/// of memory (more only where the driver limits a block's size). Nothing is freed but all together.
class Arena {
 public:
  explicit Arena(const DeviceContext* context) : context_(context) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  ~Arena();

  /// An image for storage, sampling, copying and clearing, with a view of all of it; no memory yet.
  /// \param layers  0: a plain image, else an array
  Result<const Image*> AddImage(VkFormat format, int width, int height, int layers);
  /// An image to draw into and to copy from, colours or depths by its format; no memory yet. Its
  /// layouts are the render pass's concern: RecordFirstUse is not for arenas with such images.
  Result<const Image*> AddAttachment(VkFormat format, int width, int height);
  /// \param usage  beside copying from and to it; with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT
  /// only
  ///               on devices that trace rays
  Result<const Buffer*> AddBuffer(VkDeviceSize size, VkBufferUsageFlags usage, BufferPlace place);

  /// What Allocate will take (before it), or has taken.
  MemoryUse Need() const;
  /// Allocates and binds everything added so far; once.
  Status Allocate();

  /// Records that all images go to VK_IMAGE_LAYOUT_GENERAL, whatever was in them, and are written
  /// next by `stages` with `access`.
  void RecordFirstUse(VkCommandBuffer commands, VkPipelineStageFlags stages,
                      VkAccessFlags access) const;

  /// Makes the device's writes visible to the host and the other way round where the memory is not
  /// coherent.
  Status Flush() const;
  Status Invalidate() const;

 private:
  struct Resource {
    VkMemoryRequirements need = {};
    VkMemoryPropertyFlags wanted = 0;
    VkMemoryPropertyFlags better = 0;
    VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
    bool addressed = false;
    Image* image = nullptr;
    Buffer* buffer = nullptr;
    size_t block = 0;
    VkDeviceSize offset = 0;
  };
  struct Block {
    uint32_t type = 0;
    VkDeviceSize size = 0;
    bool mapped = false;
    bool addressed = false;
    VkDeviceMemory memory = VK_NULL_HANDLE;
  };

  /// Where every resource lies; the same before and after Allocate.
  std::vector<Block> Plan(std::vector<Resource>* resources) const;
  uint32_t FindType(const Resource& resource) const;
  Result<const Image*> Add(VkFormat format, int width, int height, int layers,
                           VkImageUsageFlags usage, VkImageAspectFlags aspect);
  Status Bind(const Resource& resource);
  std::vector<VkMappedMemoryRange> MappedRanges() const;

  const DeviceContext* context_;
  std::deque<Image> images_;
  std::deque<Buffer> buffers_;
  std::vector<Resource> resources_;
  std::vector<Block> blocks_;
  bool allocated_ = false;
};

}  // namespace stillray::gpu
