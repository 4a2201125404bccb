// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Images and buffers of a device, suballocated from one allocation per memory type.
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
  VkImageView srgb_view = VK_NULL_HANDLE;  ///< sRGB view, only of AddTextures
  VkFormat format = VK_FORMAT_UNDEFINED;
  int width = 0;
  int height = 0;
  int layers = 0;  ///< array layers; 0: not an array image
};

struct Buffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize size = 0;
  void* mapped = nullptr;       ///< host address, only of host-visible buffers
  VkDeviceAddress address = 0;  ///< only of buffers whose usage includes device addresses
};

/// Bytes per texel of the formats used by stillray.
size_t TexelBytes(VkFormat format);
/// Bytes of all texels of an image.
size_t BytesOf(const Image& image);

/// Device memory used by an arena.
struct MemoryUse {
  uint32_t allocations = 0;
  uint32_t resources = 0;  ///< images and buffers
  uint64_t bytes = 0;      ///< bytes of all allocations
  uint64_t largest = 0;    ///< bytes of the largest image or buffer

  MemoryUse& operator+=(const MemoryUse& other);
};

enum class BufferPlace {
  kDevice,    ///< device-local memory
  kUpload,    ///< written by the host, read by the device
  kDownload,  ///< written by the device, read by the host; cached if possible
};

/// Images and buffers are added first, then all memory is allocated at once, in one block per
/// memory type (or several if the driver limits the allocation size). All memory is freed together.
class Arena {
 public:
  explicit Arena(const DeviceContext* context) : context_(context) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  ~Arena();

  /// Adds an image for storage, sampling, copying and clearing, with a view of the whole image;
  /// allocates no memory yet.
  /// \param layers  array layers; 0: not an array image
  Result<const Image*> AddImage(VkFormat format, int width, int height, int layers);
  /// Adds a colour or depth attachment (by its format) that can be copied from; allocates no memory
  /// yet. The render pass manages its layouts: do not call RecordFirstUse on arenas with such
  /// images.
  Result<const Image*> AddAttachment(VkFormat format, int width, int height);
  /// Adds an array image to copy to and to sample, four bytes per texel, with a linear (UNORM) and
  /// an sRGB view; allocates no memory yet. The caller manages its layouts: do not call
  /// RecordFirstUse on arenas with such images.
  Result<const Image*> AddTextures(int width, int height, int layers);
  /// \param usage  flags in addition to transfer source and destination;
  ///     VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT only on devices with ray tracing
  Result<const Buffer*> AddBuffer(VkDeviceSize size, VkBufferUsageFlags usage, BufferPlace place);

  /// The memory requirement of Allocate, before or after the call.
  MemoryUse Need() const;
  /// Allocates and binds memory for everything added so far. Call once.
  Status Allocate();

  /// Records the transition of all images to VK_IMAGE_LAYOUT_GENERAL, discarding their content, for
  /// following writes by `stages` with `access`.
  void RecordFirstUse(VkCommandBuffer commands, VkPipelineStageFlags stages,
                      VkAccessFlags access) const;

  /// Flush makes host writes visible to the device, Invalidate device writes visible to the host,
  /// if the memory is not coherent.
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
    bool from_source = false;  ///< allocated by DeviceContext::memory_source
  };

  /// Assigns every resource to a block; deterministic, hence equal before and after Allocate.
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
