// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/memory.h"

#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>

namespace stillray::gpu {
namespace {

VkDeviceSize AlignUp(VkDeviceSize offset, VkDeviceSize alignment) {
  return (offset + alignment - 1) / alignment * alignment;
}

/// Maximum block size: the guaranteed minimum of maxMemoryAllocationSize in Vulkan 1.1
/// (maintenance3).
constexpr VkDeviceSize kLargestBlock = VkDeviceSize{1} << 30;

constexpr uint32_t kNoType = std::numeric_limits<uint32_t>::max();

}  // namespace

size_t TexelBytes(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
      return 16;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R32G32_SFLOAT:
    case VK_FORMAT_R32G32_UINT:
      return 8;
    case VK_FORMAT_R16_SFLOAT:
    case VK_FORMAT_R16_UNORM:
      return 2;
    default:
      return 4;
  }
}

size_t BytesOf(const Image& image) {
  return TexelBytes(image.format) * static_cast<size_t>(image.width) *
         static_cast<size_t>(image.height) * static_cast<size_t>(std::max(image.layers, 1));
}

MemoryUse& MemoryUse::operator+=(const MemoryUse& other) {
  allocations += other.allocations;
  resources += other.resources;
  bytes += other.bytes;
  largest = std::max(largest, other.largest);
  return *this;
}

Arena::~Arena() {
  RemoveBlocks(this);
  const DeviceFunctions& vk = context_->vk;
  for (const Image& image : images_) {
    vk.DestroyImageView(context_->device, image.view, nullptr);
    vk.DestroyImageView(context_->device, image.srgb_view, nullptr);
    vk.DestroyImage(context_->device, image.image, nullptr);
  }
  for (const Buffer& buffer : buffers_) {
    vk.DestroyBuffer(context_->device, buffer.buffer, nullptr);
  }
  for (const Block& block : blocks_) {
    if (block.from_source) {
      context_->memory_source.free(block.own);
    } else {
      vk.FreeMemory(context_->device, block.own.memory, nullptr);
    }
  }
}

Result<const Image*> Arena::AddImage(VkFormat format, int width, int height, int layers) {
  return Add(format, width, height, layers,
             VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT |
                 VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
             VK_IMAGE_ASPECT_COLOR_BIT);
}

Result<const Image*> Arena::AddAttachment(VkFormat format, int width, int height) {
  const bool depth = format == VK_FORMAT_D32_SFLOAT;
  return depth ? Add(format, width, height, 0, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT,
                     VK_IMAGE_ASPECT_DEPTH_BIT)
               : Add(format, width, height, 0,
                     VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                     VK_IMAGE_ASPECT_COLOR_BIT);
}

Result<const Image*> Arena::AddTextures(int width, int height, int layers) {
  return Add(VK_FORMAT_R8G8B8A8_UNORM, width, height, layers,
             VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
             VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT);
}

Result<const Image*> Arena::Add(VkFormat format, int width, int height, int layers,
                                VkImageUsageFlags usage, VkImageAspectFlags aspect,
                                VkImageCreateFlags flags) {
  VkImageCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  info.flags = flags;
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = format;
  info.extent = {static_cast<uint32_t>(width), static_cast<uint32_t>(height), 1};
  info.mipLevels = 1;
  info.arrayLayers = static_cast<uint32_t>(std::max(layers, 1));
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = usage;
  Image image;
  image.format = format;
  image.width = width;
  image.height = height;
  image.layers = layers;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(context_->vk.CreateImage(context_->device, &info, nullptr, &image.image),
               "creating an image"));
  images_.push_back(image);
  Resource resource;
  resource.image = &images_.back();
  resource.aspect = aspect;
  resource.has_srgb = (flags & VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT) != 0;
  resource.wanted = 0;
  resource.better = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  context_->vk.GetImageMemoryRequirements(context_->device, image.image, &resource.need);
  resources_.push_back(resource);
  return &images_.back();
}

Result<const Buffer*> Arena::AddBuffer(VkDeviceSize size, VkBufferUsageFlags usage,
                                       BufferPlace place) {
  VkBufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = size;
  info.usage = usage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  if ((usage & VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT) != 0) {
    info.usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;  // see uniform_blocks.h
  }
  Buffer buffer;
  buffer.size = size;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(context_->vk.CreateBuffer(context_->device, &info, nullptr, &buffer.buffer),
               "creating a buffer"));
  buffers_.push_back(buffer);
  Resource resource;
  resource.buffer = &buffers_.back();
  resource.addressed = (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0;
  const bool on_device = place == BufferPlace::kDevice;
  resource.wanted = on_device ? 0 : VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  resource.better = on_device                       ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
                    : place == BufferPlace::kUpload ? VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
                                                    : VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  context_->vk.GetBufferMemoryRequirements(context_->device, buffer.buffer, &resource.need);
  resources_.push_back(resource);
  return &buffers_.back();
}

/// The first memory type with the required and preferred flags, else with the required flags;
/// kNoType if there is none.
uint32_t Arena::FindType(const Resource& resource) const {
  uint32_t fallback = kNoType;
  for (uint32_t i = 0; i < context_->memory.memoryTypeCount; ++i) {
    const VkMemoryPropertyFlags flags = context_->memory.memoryTypes[i].propertyFlags;
    if ((resource.need.memoryTypeBits >> i & 1u) == 0 ||
        (flags & resource.wanted) != resource.wanted) {
      continue;
    }
    if ((flags & resource.better) == resource.better) {
      return i;
    }
    fallback = fallback == kNoType ? i : fallback;
  }
  return fallback;
}

std::vector<Arena::Block> Arena::Plan(std::vector<Resource>* resources) const {
  std::vector<Block> blocks;
  for (Resource& r : *resources) {
    const uint32_t type = FindType(r);
    // Images and buffers may share a block: bufferImageGranularity separates them.
    const VkDeviceSize alignment =
        std::max(r.need.alignment, context_->limits.bufferImageGranularity);
    const bool mapped = (r.wanted & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) != 0;
    r.block = blocks.size();
    for (size_t i = 0; i < blocks.size(); ++i) {
      if (blocks[i].type == type && blocks[i].mapped == mapped &&
          blocks[i].addressed == r.addressed &&
          AlignUp(blocks[i].size, alignment) + r.need.size <= kLargestBlock) {
        r.block = i;
        break;
      }
    }
    if (r.block == blocks.size()) {
      Block block;
      block.type = type;
      block.mapped = mapped;
      block.addressed = r.addressed;
      blocks.push_back(block);
    }
    blocks[r.block].alignment = std::max(blocks[r.block].alignment, alignment);
    r.offset = AlignUp(blocks[r.block].size, alignment);
    blocks[r.block].size = r.offset + r.need.size;
  }
  return blocks;
}

MemoryUse Arena::Need() const {
  std::vector<Resource> resources = resources_;
  MemoryUse use;
  for (const Block& block : Plan(&resources)) {
    ++use.allocations;
    use.bytes += block.size;
  }
  use.resources = static_cast<uint32_t>(resources.size());
  for (const Resource& r : resources) {
    use.largest = std::max<uint64_t>(use.largest, r.need.size);
  }
  return use;
}

/// Checks the heap sizes before the first allocation: drivers fail late or first slow down.
Status Arena::CheckHeaps() const {
  std::array<VkDeviceSize, VK_MAX_MEMORY_HEAPS> taken = {};
  for (const Block& block : blocks_) {
    if (block.type == kNoType) {
      return Status::Unsupported("Vulkan: the device has no memory of a kind that is needed");
    }
    taken[context_->memory.memoryTypes[block.type].heapIndex] += block.size;
  }
  for (uint32_t heap = 0; heap < context_->memory.memoryHeapCount; ++heap) {
    const VkDeviceSize most = context_->memory.memoryHeaps[heap].size;
    if (taken[heap] > most) {
      return Status::OutOfMemory(
          fmt::format("Vulkan: images and buffers take {:.1f} MB, the device has {:.1f} MB",
                      static_cast<double>(taken[heap]) / 1e6, static_cast<double>(most) / 1e6));
    }
  }
  return Status::Ok();
}

Status Arena::AllocateBlock(Block* block) const {
  constexpr const char* kAction = "allocating device memory";
  if (context_->memory_source.allocate && !block->mapped && !block->addressed) {
    const VkMemoryRequirements need = {block->size, block->alignment, 1u << block->type};
    STILLRAY_RETURN_IF_ERROR(
        ToStatus(context_->memory_source.allocate(need, &block->own), kAction));
    block->from_source = true;
    return Status::Ok();
  }
  VkMemoryAllocateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  info.allocationSize = block->size;
  info.memoryTypeIndex = block->type;
  VkMemoryAllocateFlagsInfo flags = {};
  flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  info.pNext = block->addressed ? &flags : nullptr;
  return ToStatus(context_->vk.AllocateMemory(context_->device, &info, nullptr, &block->own.memory),
                  kAction);
}

Status Arena::Allocate() {
  if (allocated_) {
    return Status::Internal("Vulkan: an arena was allocated twice");
  }
  allocated_ = true;
  blocks_ = Plan(&resources_);
  STILLRAY_RETURN_IF_ERROR(CheckHeaps());
  for (Block& block : blocks_) {
    STILLRAY_RETURN_IF_ERROR(AllocateBlock(&block));
  }
  CountBlocks(this, MemoryPlace::kDevice, Blocks());
  for (const Resource& resource : resources_) {
    STILLRAY_RETURN_IF_ERROR(Bind(resource));
  }
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (!blocks_[i].mapped) {
      continue;
    }
    void* start = nullptr;
    STILLRAY_RETURN_IF_ERROR(
        ToStatus(context_->vk.MapMemory(context_->device, blocks_[i].own.memory, 0, VK_WHOLE_SIZE,
                                        0, &start),
                 "mapping device memory"));
    for (const Resource& r : resources_) {
      if (r.block == i && r.buffer != nullptr) {
        r.buffer->mapped = static_cast<char*>(start) + r.offset;
      }
    }
  }
  return Status::Ok();
}

MemoryBlocks Arena::Blocks() const {
  MemoryBlocks own;
  std::vector<VkDeviceSize> ends(blocks_.size(), 0);
  // Resources of a block are consecutive, in the order of their addition.
  for (const Resource& r : resources_) {
    own.AddAllocation(r.need.size);
    own.AddUnused(r.offset - ends[r.block]);
    ends[r.block] = r.offset + r.need.size;
  }
  for (size_t i = 0; i < blocks_.size(); ++i) {
    ++own.blocks;
    own.block_bytes += blocks_[i].size;
    own.AddUnused(blocks_[i].size - ends[i]);
  }
  return own;
}

Status Arena::Bind(const Resource& r) {
  const VkDeviceMemory memory = blocks_[r.block].own.memory;
  const VkDeviceSize offset = blocks_[r.block].own.offset + r.offset;
  if (r.buffer != nullptr) {
    STILLRAY_RETURN_IF_ERROR(
        ToStatus(context_->vk.BindBufferMemory(context_->device, r.buffer->buffer, memory, offset),
                 "binding a buffer"));
    if (r.addressed) {
      VkBufferDeviceAddressInfo info = {};
      info.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO;
      info.buffer = r.buffer->buffer;
      r.buffer->address = context_->vk.GetBufferDeviceAddressKHR(context_->device, &info);
    }
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(context_->vk.BindImageMemory(context_->device, r.image->image, memory, offset),
               "binding an image"));
  VkImageViewCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
  info.image = r.image->image;
  info.viewType = r.image->layers > 0 ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
  info.format = r.image->format;
  info.subresourceRange = {r.aspect, 0, 1, 0, static_cast<uint32_t>(std::max(r.image->layers, 1))};
  constexpr const char* kAction = "creating an image view";
  const auto create = [&](VkImageView* view) {
    return ToStatus(context_->vk.CreateImageView(context_->device, &info, nullptr, view), kAction);
  };
  STILLRAY_RETURN_IF_ERROR(create(&r.image->view));
  info.format = VK_FORMAT_R8G8B8A8_SRGB;
  return r.has_srgb ? create(&r.image->srgb_view) : Status::Ok();
}

std::vector<VkMappedMemoryRange> Arena::MappedRanges() const {
  std::vector<VkMappedMemoryRange> ranges;
  for (const Block& block : blocks_) {
    if (block.mapped) {
      VkMappedMemoryRange range = {};
      range.sType = VK_STRUCTURE_TYPE_MAPPED_MEMORY_RANGE;
      range.memory = block.own.memory;
      range.size = VK_WHOLE_SIZE;
      ranges.push_back(range);
    }
  }
  return ranges;
}

void Arena::RecordFirstUse(VkCommandBuffer commands, VkPipelineStageFlags stages,
                           VkAccessFlags access) const {
  std::vector<VkImageMemoryBarrier> barriers;
  for (const Image& image : images_) {
    VkImageMemoryBarrier barrier = {};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.dstAccessMask = access;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image.image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
    barriers.push_back(barrier);
  }
  context_->vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, stages, 0, 0,
                                  nullptr, 0, nullptr, static_cast<uint32_t>(barriers.size()),
                                  barriers.data());
}

namespace {

/// Shared by flushing and invalidating.
Status ForRanges(const DeviceContext& context, const std::vector<VkMappedMemoryRange>& ranges,
                 PFN_vkFlushMappedMemoryRanges function, const char* action) {
  return ranges.empty() ? Status::Ok()
                        : ToStatus(function(context.device, static_cast<uint32_t>(ranges.size()),
                                            ranges.data()),
                                   action);
}

}  // namespace

Status Arena::Flush() const {
  return ForRanges(*context_, MappedRanges(), context_->vk.FlushMappedMemoryRanges,
                   "flushing mapped memory");
}

Status Arena::Invalidate() const {
  return ForRanges(*context_, MappedRanges(), context_->vk.InvalidateMappedMemoryRanges,
                   "reading mapped memory");
}

}  // namespace stillray::gpu
