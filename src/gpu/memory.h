// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Images and buffers of a device, with one allocation per memory type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "core/memory_blocks.h"
#include "gpu/device.h"

namespace stillray::gpu {

/// An image of the arena. Valid for the arena's lifetime.
struct Image {
  VkImage image = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  VkImageView srgb_view = VK_NULL_HANDLE;  ///< of AddTextures
  VkFormat format = VK_FORMAT_UNDEFINED;
  int width = 0;
  int height = 0;
  int layers = 0;  ///< 0: a plain image, not an array of one
};

struct Buffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize size = 0;
  void* mapped = nullptr;       ///< of host-visible buffers
  VkDeviceAddress address = 0;  ///< of buffers whose usage includes it
};

/// Of one of the formats that stillray uses.
size_t TexelBytes(VkFormat format);
/// Bytes of all texels of an image.
size_t BytesOf(const Image& image);

/// Device memory used by an arena.
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

/// Images and buffers are added first, then all memory is allocated at once, in one block per
/// memory type (more only where the driver limits the size of a block). All memory is freed
/// together.
class Arena {
 public:
  explicit Arena(const DeviceContext* context) : context_(context) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  ~Arena();

  /// Adds an image for storage, sampling, copying and clearing, with a view of all of it; allocates
  /// no memory yet.
  /// \param layers  0: a plain image, else an array
  Result<const Image*> AddImage(VkFormat format, int width, int height, int layers);
  /// Adds an image to draw into and to copy from, colour or depth by its format; allocates no
  /// memory yet. The render pass manages its layouts: do not call RecordFirstUse on arenas with
  /// such images.
  Result<const Image*> AddAttachment(VkFormat format, int width, int height);
  /// Adds an array of images to copy into and to sample, four bytes per texel, with views of bytes
  /// as they are and of colours in sRGB; allocates no memory yet. The caller manages its layouts:
  /// do not call RecordFirstUse on arenas with such images.
  Result<const Image*> AddTextures(int width, int height, int layers);
  /// \param usage  beside copies from and to it; VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT only on
  ///     devices with ray tracing
  Result<const Buffer*> AddBuffer(VkDeviceSize size, VkBufferUsageFlags usage, BufferPlace place);

  /// The memory that Allocate will take, or has taken.
  MemoryUse Need() const;
  /// Allocates and binds memory for everything added so far. Call once.
  Status Allocate();

  /// Records the transition of all images to VK_IMAGE_LAYOUT_GENERAL, discarding their content;
  /// `stages` write them next with `access`.
  void RecordFirstUse(VkCommandBuffer commands, VkPipelineStageFlags stages,
                      VkAccessFlags access) const;

  /// Makes the device's writes visible to the host and vice versa where the memory is not coherent.
  Status Flush() const;
  Status Invalidate() const;

 private:
  struct Resource {
    VkMemoryRequirements need = {};
    VkMemoryPropertyFlags wanted = 0;
    VkMemoryPropertyFlags better = 0;
    VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
    bool has_srgb = false;
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
    VkDeviceSize alignment = 1;
    OwnedMemory own;
    bool from_source = false;  ///< of DeviceContext::memory_source
  };

  /// Places every resource; the same before and after Allocate.
  std::vector<Block> Plan(std::vector<Resource>* resources) const;
  uint32_t FindType(const Resource& resource) const;
  MemoryBlocks Blocks() const;
  Result<const Image*> Add(VkFormat format, int width, int height, int layers,
                           VkImageUsageFlags usage, VkImageAspectFlags aspect,
                           VkImageCreateFlags flags = 0);
  Status CheckHeaps() const;
  Status AllocateBlock(Block* block) const;
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
