// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/shared_memory.h"

#include <algorithm>

#include "core/memory_blocks.h"
#include "gpu/device.h"
#include "gpu/extensions.h"

namespace stillray::gpu {
namespace {

constexpr VkExternalMemoryHandleTypeFlagBits kHandle = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;

/// Granularity of the memory size: importers round sizes up differently, and reject memory smaller
/// than the rounded size.
constexpr VkDeviceSize kPage = 4096;

bool ExportsBuffers(const InstanceFunctions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceExternalBufferInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_BUFFER_INFO;
  info.usage = kUsage;
  info.handleType = kHandle;
  VkExternalBufferProperties properties = {};
  properties.sType = VK_STRUCTURE_TYPE_EXTERNAL_BUFFER_PROPERTIES;
  vk.GetPhysicalDeviceExternalBufferProperties(device, &info, &properties);
  const VkExternalMemoryFeatureFlags features =
      properties.externalMemoryProperties.externalMemoryFeatures;
  return (features & VK_EXTERNAL_MEMORY_FEATURE_EXPORTABLE_BIT) != 0 &&
         (features & VK_EXTERNAL_MEMORY_FEATURE_DEDICATED_ONLY_BIT) == 0;
}

/// A memory type among `allowed`, device-local if there is one.
uint32_t FindType(const VkPhysicalDeviceMemoryProperties& memory, uint32_t allowed) {
  constexpr VkMemoryPropertyFlags kPreferred[] = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0};
  for (const VkMemoryPropertyFlags wanted : kPreferred) {
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
      if ((allowed >> i & 1u) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) {
        return i;
      }
    }
  }
  return 0;
}

}  // namespace

MemorySharing FindMemorySharing(const InstanceFunctions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceProperties basic = {};
  vk.GetPhysicalDeviceProperties(device, &basic);
  if (basic.apiVersion < VK_API_VERSION_1_1 || !HasExtensions(vk, device, kSharingExtensions) ||
      !ExportsBuffers(vk, device)) {
    return {};
  }
  VkPhysicalDeviceIDProperties ids = {};
  ids.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES;
  VkPhysicalDeviceProperties2 properties = {};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &ids;
  vk.GetPhysicalDeviceProperties2(device, &properties);
  MemorySharing found;
  found.offered = true;
  std::copy_n(ids.deviceUUID, VK_UUID_SIZE, found.device.begin());
  std::copy_n(ids.driverUUID, VK_UUID_SIZE, found.driver.begin());
  return found;
}

Result<std::unique_ptr<SharedBuffer>> SharedBuffer::Create(const DeviceContext* context,
                                                           VkDeviceSize bytes) {
  if (!context->sharing.offered) {
    return Status::Unsupported("Vulkan: the device shares no memory with other APIs");
  }
  std::unique_ptr<SharedBuffer> made(new SharedBuffer(context));
  STILLRAY_RETURN_IF_ERROR(made->Make(bytes));
  return made;
}

Status SharedBuffer::Make(VkDeviceSize bytes) {
  const DeviceFunctions& vk = context_->vk;
  VkExternalMemoryBufferCreateInfo external = {};
  external.sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO;
  external.handleTypes = kHandle;
  VkBufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.pNext = &external;
  info.size = (bytes + kPage - 1) / kPage * kPage + kPage;
  info.usage = kUsage;
  STILLRAY_RETURN_IF_ERROR(ToStatus(vk.CreateBuffer(context_->device, &info, nullptr, &buffer_),
                                    "creating a shared buffer"));
  VkMemoryRequirements need = {};
  vk.GetBufferMemoryRequirements(context_->device, buffer_, &need);
  VkExportMemoryAllocateInfo exported = {};
  exported.sType = VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO;
  exported.handleTypes = kHandle;
  VkMemoryAllocateInfo allocate = {};
  allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  allocate.pNext = &exported;
  allocate.allocationSize = need.size;
  allocate.memoryTypeIndex = FindType(context_->memory, need.memoryTypeBits);
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(vk.AllocateMemory(context_->device, &allocate, nullptr, &memory_),
               "allocating shared memory"));
  memory_bytes_ = need.size;
  MemoryBlocks own;
  own.blocks = 1;
  own.block_bytes = need.size;
  own.AddAllocation(need.size);
  CountBlocks(this, MemoryPlace::kDevice, own);
  return ToStatus(vk.BindBufferMemory(context_->device, buffer_, memory_, 0),
                  "binding a shared buffer");
}

SharedBuffer::~SharedBuffer() {
  RemoveBlocks(this);
  context_->vk.DestroyBuffer(context_->device, buffer_, nullptr);
  context_->vk.FreeMemory(context_->device, memory_, nullptr);
}

Result<int> SharedBuffer::Export() const {
  VkMemoryGetFdInfoKHR info = {};
  info.sType = VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR;
  info.memory = memory_;
  info.handleType = kHandle;
  int descriptor = -1;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(context_->vk.GetMemoryFdKHR(context_->device, &info, &descriptor),
               "exporting shared memory"));
  return descriptor;
}

void RecordRelease(const DeviceContext& context, VkCommandBuffer commands, uint32_t queue_family,
                   const SharedBuffer& buffer) {
  VkBufferMemoryBarrier barrier = {};
  barrier.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER;
  barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
  barrier.srcQueueFamilyIndex = queue_family;
  barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_EXTERNAL;
  barrier.buffer = buffer.buffer();
  barrier.size = VK_WHOLE_SIZE;
  context.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0, 0, nullptr, 1, &barrier, 0,
                                nullptr);
}

}  // namespace stillray::gpu
