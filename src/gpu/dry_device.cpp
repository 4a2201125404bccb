// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/dry_device.h"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "core/check.h"

namespace stillray::gpu {
namespace {

/// Non-dispatchable handles are consecutive numbers from 1.
template <typename Handle>
Handle ToHandle(size_t index) {
  return (Handle)(index + 1);  // a pointer, or a number where pointers have 32 bits
}
template <typename Handle>
size_t ToIndex(Handle handle) {
  return (size_t)handle - 1;
}

template <typename Handle>
DryDevice& Of(Handle dispatchable) {
  return *reinterpret_cast<DryDevice*>(dispatchable);
}

template <typename T, typename Handle>
VkResult Add(std::vector<T>* list, T entry, Handle* handle) {
  *handle = ToHandle<Handle>(list->size());
  list->push_back(std::move(entry));
  return VK_SUCCESS;
}

std::string_view WithoutPrefix(std::string_view label) {
  constexpr std::string_view kPrefix = "stillray: ";
  return label.starts_with(kPrefix) ? label.substr(kPrefix.size()) : label;
}

/// Stub for functions that are never called on a dry device.
VKAPI_ATTR void VKAPI_CALL NotOffered() {
  STILLRAY_CHECK(false);
}
VKAPI_ATTR void VKAPI_CALL Nothing() {}

}  // namespace

/// Implementations of Vulkan functions, named without the prefix vk.
struct DryFunctions {
  // --- device properties
  static VKAPI_ATTR void VKAPI_CALL GetPhysicalDeviceProperties(VkPhysicalDevice physical,
                                                                VkPhysicalDeviceProperties* p) {
    *p = {};
    p->apiVersion = VK_API_VERSION_1_1;
    p->deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
    std::strcpy(p->deviceName, "dry run");
    VkPhysicalDeviceLimits& limits = p->limits;
    limits.maxImageDimension2D = 16384;
    limits.maxPerStageDescriptorSampledImages = 1024;
    limits.maxPerStageDescriptorStorageImages = 1024;
    limits.maxComputeWorkGroupInvocations = 1024;
    limits.maxComputeWorkGroupSize[0] = 1024;
    limits.maxComputeSharedMemorySize = Of(physical).shared_memory_;
    limits.bufferImageGranularity = 1;
  }
  static VKAPI_ATTR void VKAPI_CALL GetPhysicalDeviceFeatures(VkPhysicalDevice,
                                                              VkPhysicalDeviceFeatures* features) {
    *features = {};
    features->shaderStorageImageExtendedFormats = VK_TRUE;
  }
  static VKAPI_ATTR void VKAPI_CALL GetPhysicalDeviceFormatProperties(VkPhysicalDevice, VkFormat,
                                                                      VkFormatProperties* offered) {
    *offered = {};
    offered->optimalTilingFeatures =
        VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
  }
  static VKAPI_ATTR void VKAPI_CALL
  GetPhysicalDeviceMemoryProperties(VkPhysicalDevice, VkPhysicalDeviceMemoryProperties* memory) {
    *memory = {};
    memory->memoryTypeCount = 1;
    memory->memoryTypes[0].propertyFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    memory->memoryHeapCount = 1;
    memory->memoryHeaps[0].size = ~VkDeviceSize{0};
  }
  static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice, const char* name) {
    return Find(name);
  }

  // --- memory (nothing is allocated)
  static VKAPI_ATTR VkResult VKAPI_CALL AllocateMemory(VkDevice, const VkMemoryAllocateInfo*,
                                                       const VkAllocationCallbacks*,
                                                       VkDeviceMemory* memory) {
    *memory = ToHandle<VkDeviceMemory>(0);
    return VK_SUCCESS;
  }
  static VKAPI_ATTR VkResult VKAPI_CALL BindBufferMemory(VkDevice, VkBuffer, VkDeviceMemory,
                                                         VkDeviceSize) {
    return VK_SUCCESS;
  }
  static VKAPI_ATTR VkResult VKAPI_CALL BindImageMemory(VkDevice, VkImage, VkDeviceMemory,
                                                        VkDeviceSize) {
    return VK_SUCCESS;
  }
  static VKAPI_ATTR void VKAPI_CALL GetBufferMemoryRequirements(VkDevice device, VkBuffer buffer,
                                                                VkMemoryRequirements* need) {
    *need = {Of(device).buffers_[ToIndex(buffer)].size, 1, 1};
  }
  static VKAPI_ATTR void VKAPI_CALL GetImageMemoryRequirements(VkDevice, VkImage,
                                                               VkMemoryRequirements* need) {
    *need = {1, 1, 1};
  }

  // --- resources
  static VKAPI_ATTR VkResult VKAPI_CALL CreateBuffer(VkDevice device,
                                                     const VkBufferCreateInfo* info,
                                                     const VkAllocationCallbacks*,
                                                     VkBuffer* buffer) {
    return Add(&Of(device).buffers_, {info->size, info->usage}, buffer);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL CreateImage(VkDevice device, const VkImageCreateInfo* info,
                                                    const VkAllocationCallbacks*, VkImage* image) {
    return Add(&Of(device).images_,
               {info->format, info->usage, info->extent.width, info->extent.height,
                info->arrayLayers, false},
               image);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL CreateImageView(VkDevice device,
                                                        const VkImageViewCreateInfo* info,
                                                        const VkAllocationCallbacks*,
                                                        VkImageView* view) {
    const size_t image = ToIndex(info->image);
    Of(device).images_[image].is_array = info->viewType == VK_IMAGE_VIEW_TYPE_2D_ARRAY;
    return Add(&Of(device).views_, image, view);
  }

  // --- pipelines
  static VKAPI_ATTR VkResult VKAPI_CALL CreateShaderModule(VkDevice device,
                                                           const VkShaderModuleCreateInfo* info,
                                                           const VkAllocationCallbacks*,
                                                           VkShaderModule* module) {
    const uint32_t* const code = info->pCode;
    return Add(&Of(device).modules_, {code, code + info->codeSize / sizeof(uint32_t)}, module);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL
  CreateDescriptorSetLayout(VkDevice device, const VkDescriptorSetLayoutCreateInfo* info,
                            const VkAllocationCallbacks*, VkDescriptorSetLayout* layout) {
    DryDevice::SetLayout made;
    for (uint32_t i = 0; i < info->bindingCount; ++i) {
      STILLRAY_CHECK_EQ(info->pBindings[i].binding, i);
      made.types.push_back(info->pBindings[i].descriptorType);
    }
    return Add(&Of(device).set_layouts_, std::move(made), layout);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL CreatePipelineLayout(VkDevice device,
                                                             const VkPipelineLayoutCreateInfo* info,
                                                             const VkAllocationCallbacks*,
                                                             VkPipelineLayout* layout) {
    DryDevice::PipelineLayout made;
    for (uint32_t i = 0; i < info->setLayoutCount; ++i) {
      made.sets.push_back(ToIndex(info->pSetLayouts[i]));
    }
    made.push_bytes = info->pushConstantRangeCount > 0 ? info->pPushConstantRanges->size : 0;
    return Add(&Of(device).layouts_, std::move(made), layout);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL CreateComputePipelines(
      VkDevice device, VkPipelineCache, uint32_t count, const VkComputePipelineCreateInfo* infos,
      const VkAllocationCallbacks*, VkPipeline* pipelines) {
    DryDevice& dry = Of(device);
    for (uint32_t i = 0; i < count; ++i) {
      DryDevice::Pipeline made;
      made.code = dry.modules_[ToIndex(infos[i].stage.module)];
      const DryDevice::PipelineLayout& layout = dry.layouts_[ToIndex(infos[i].layout)];
      for (const size_t set : layout.sets) {
        made.sets.push_back(dry.set_layouts_[set].types);
      }
      made.push_bytes = layout.push_bytes;
      const VkSpecializationInfo* constants = infos[i].stage.pSpecializationInfo;
      for (uint32_t k = 0; constants != nullptr && k < constants->mapEntryCount; ++k) {
        const VkSpecializationMapEntry& entry = constants->pMapEntries[k];
        std::memcpy(&made.constants[entry.constantID],
                    static_cast<const char*>(constants->pData) + entry.offset, sizeof(uint32_t));
      }
      Add(&dry.pipelines_, std::move(made), &pipelines[i]);
    }
    return VK_SUCCESS;
  }

  // --- descriptor sets
  static VKAPI_ATTR VkResult VKAPI_CALL CreateDescriptorPool(VkDevice,
                                                             const VkDescriptorPoolCreateInfo*,
                                                             const VkAllocationCallbacks*,
                                                             VkDescriptorPool* pool) {
    *pool = ToHandle<VkDescriptorPool>(0);
    return VK_SUCCESS;
  }
  static VKAPI_ATTR VkResult VKAPI_CALL ResetDescriptorPool(VkDevice, VkDescriptorPool,
                                                            VkDescriptorPoolResetFlags) {
    return VK_SUCCESS;
  }
  static VKAPI_ATTR VkResult VKAPI_CALL AllocateDescriptorSets(
      VkDevice device, const VkDescriptorSetAllocateInfo* info, VkDescriptorSet* sets) {
    DryDevice& dry = Of(device);
    for (uint32_t i = 0; i < info->descriptorSetCount; ++i) {
      const size_t size = dry.set_layouts_[ToIndex(info->pSetLayouts[i])].types.size();
      Add(&dry.sets_, std::vector<DryDescriptor>(size), &sets[i]);
    }
    return VK_SUCCESS;
  }
  static VKAPI_ATTR void VKAPI_CALL UpdateDescriptorSets(VkDevice device, uint32_t count,
                                                         const VkWriteDescriptorSet* writes,
                                                         uint32_t, const VkCopyDescriptorSet*) {
    DryDevice& dry = Of(device);
    for (uint32_t i = 0; i < count; ++i) {
      const VkWriteDescriptorSet& w = writes[i];
      DryDescriptor& d = dry.sets_[ToIndex(w.dstSet)][w.dstBinding];
      d.binding = w.dstBinding;
      d.type = w.descriptorType;
      if (w.pImageInfo != nullptr) {
        d.resource = dry.ImageOf(w.pImageInfo->imageView);
        d.layout = w.pImageInfo->imageLayout;
      } else {
        d.resource = ToIndex(w.pBufferInfo->buffer);
      }
    }
  }

  // --- commands
  static DryCommand& Record(VkCommandBuffer commands, DryCommand::Kind kind) {
    DryDevice& dry = Of(commands);
    DryCommand& c = dry.recorded_.emplace_back();
    c.kind = kind;
    c.part = dry.part_;
    return c;
  }
  static VKAPI_ATTR void VKAPI_CALL CmdBindPipeline(VkCommandBuffer commands, VkPipelineBindPoint,
                                                    VkPipeline pipeline) {
    Of(commands).bound_pipeline_ = ToIndex(pipeline);
    Of(commands).push_.clear();
  }
  static VKAPI_ATTR void VKAPI_CALL CmdBindDescriptorSets(VkCommandBuffer commands,
                                                          VkPipelineBindPoint, VkPipelineLayout,
                                                          uint32_t first, uint32_t count,
                                                          const VkDescriptorSet* sets, uint32_t,
                                                          const uint32_t*) {
    STILLRAY_CHECK_EQ(first, 0u);
    std::vector<size_t>& bound = Of(commands).bound_sets_;
    bound.clear();
    for (uint32_t i = 0; i < count; ++i) {
      bound.push_back(ToIndex(sets[i]));
    }
  }
  static VKAPI_ATTR void VKAPI_CALL CmdPushConstants(VkCommandBuffer commands, VkPipelineLayout,
                                                     VkShaderStageFlags, uint32_t offset,
                                                     uint32_t size, const void* values) {
    STILLRAY_CHECK_EQ(offset, 0u);
    const auto* const bytes = static_cast<const std::byte*>(values);
    Of(commands).push_.assign(bytes, bytes + size);
  }
  static VKAPI_ATTR void VKAPI_CALL CmdDispatch(VkCommandBuffer commands, uint32_t x, uint32_t y,
                                                uint32_t z) {
    DryDevice& dry = Of(commands);
    DryCommand& c = Record(commands, DryCommand::Kind::kDispatch);
    c.pipeline = dry.bound_pipeline_;
    for (const size_t set : dry.bound_sets_) {
      c.sets.push_back(dry.sets_[set]);
    }
    c.groups[0] = x;
    c.groups[1] = y;
    c.groups[2] = z;
    c.bytes = dry.push_;
  }
  static VKAPI_ATTR void VKAPI_CALL
  CmdPipelineBarrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkPipelineStageFlags to,
                     VkDependencyFlags, uint32_t memory_count, const VkMemoryBarrier* memory,
                     uint32_t buffer_count, const VkBufferMemoryBarrier*, uint32_t image_count,
                     const VkImageMemoryBarrier* images) {
    STILLRAY_CHECK_EQ(buffer_count, 0u);
    for (uint32_t i = 0; i < memory_count; ++i) {
      DryCommand& c = Record(commands, DryCommand::Kind::kBarrier);
      c.from = from;
      c.to = to;
      c.written = memory[i].srcAccessMask;
      c.used = memory[i].dstAccessMask;
    }
    for (uint32_t i = 0; i < image_count; ++i) {
      STILLRAY_CHECK_EQ(images[i].oldLayout, VK_IMAGE_LAYOUT_UNDEFINED);
      DryCommand& c = Record(commands, DryCommand::Kind::kTransition);
      c.from = from;
      c.to = to;
      c.used = images[i].dstAccessMask;
      c.image = ToIndex(images[i].image);
      c.layout = images[i].newLayout;
    }
  }
  static VKAPI_ATTR void VKAPI_CALL CmdFillBuffer(VkCommandBuffer commands, VkBuffer buffer,
                                                  VkDeviceSize offset, VkDeviceSize size,
                                                  uint32_t value) {
    DryCommand& c = Record(commands, DryCommand::Kind::kFill);
    c.buffer = ToIndex(buffer);
    c.offset = offset;
    // VK_WHOLE_SIZE is rounded down to words of 4 bytes.
    const uint64_t rest = (Of(commands).buffers_[c.buffer].size - offset) / 4 * 4;
    c.size = size == VK_WHOLE_SIZE ? rest : size;
    c.value = value;
  }
  static VKAPI_ATTR void VKAPI_CALL CmdUpdateBuffer(VkCommandBuffer commands, VkBuffer buffer,
                                                    VkDeviceSize offset, VkDeviceSize size,
                                                    const void* data) {
    DryCommand& c = Record(commands, DryCommand::Kind::kUpdate);
    c.buffer = ToIndex(buffer);
    c.offset = offset;
    c.size = size;
    const auto* const bytes = static_cast<const std::byte*>(data);
    c.bytes.assign(bytes, bytes + size);
  }
  static VKAPI_ATTR void VKAPI_CALL CmdBeginDebugUtilsLabelEXT(VkCommandBuffer commands,
                                                               const VkDebugUtilsLabelEXT* label) {
    Of(commands).part_ = WithoutPrefix(label->pLabelName);
  }
  static VKAPI_ATTR void VKAPI_CALL CmdEndDebugUtilsLabelEXT(VkCommandBuffer commands) {
    Of(commands).part_.clear();
  }

  static PFN_vkVoidFunction Find(std::string_view name) {
#define STILLRAY_DRY_(function) \
  { "vk" #function, reinterpret_cast<PFN_vkVoidFunction>(&function) }
    static const std::pair<std::string_view, PFN_vkVoidFunction> kFunctions[] = {
        STILLRAY_DRY_(GetPhysicalDeviceProperties),
        STILLRAY_DRY_(GetPhysicalDeviceFeatures),
        STILLRAY_DRY_(GetPhysicalDeviceFormatProperties),
        STILLRAY_DRY_(GetPhysicalDeviceMemoryProperties),
        STILLRAY_DRY_(GetDeviceProcAddr),
        STILLRAY_DRY_(AllocateMemory),
        STILLRAY_DRY_(BindBufferMemory),
        STILLRAY_DRY_(BindImageMemory),
        STILLRAY_DRY_(GetBufferMemoryRequirements),
        STILLRAY_DRY_(GetImageMemoryRequirements),
        STILLRAY_DRY_(CreateBuffer),
        STILLRAY_DRY_(CreateImage),
        STILLRAY_DRY_(CreateImageView),
        STILLRAY_DRY_(CreateShaderModule),
        STILLRAY_DRY_(CreateDescriptorSetLayout),
        STILLRAY_DRY_(CreatePipelineLayout),
        STILLRAY_DRY_(CreateComputePipelines),
        STILLRAY_DRY_(CreateDescriptorPool),
        STILLRAY_DRY_(ResetDescriptorPool),
        STILLRAY_DRY_(AllocateDescriptorSets),
        STILLRAY_DRY_(UpdateDescriptorSets),
        STILLRAY_DRY_(CmdBindPipeline),
        STILLRAY_DRY_(CmdBindDescriptorSets),
        STILLRAY_DRY_(CmdPushConstants),
        STILLRAY_DRY_(CmdDispatch),
        STILLRAY_DRY_(CmdPipelineBarrier),
        STILLRAY_DRY_(CmdFillBuffer),
        STILLRAY_DRY_(CmdUpdateBuffer),
        STILLRAY_DRY_(CmdBeginDebugUtilsLabelEXT),
        STILLRAY_DRY_(CmdEndDebugUtilsLabelEXT)};
#undef STILLRAY_DRY_
    const auto* const found = std::ranges::find(
        kFunctions, name, &std::pair<std::string_view, PFN_vkVoidFunction>::first);
    if (found != std::end(kFunctions)) {
      return found->second;
    }
    const bool frees = name.starts_with("vkDestroy") || name == "vkFreeMemory";
    return frees ? &Nothing : &NotOffered;
  }
};

PFN_vkGetInstanceProcAddr DryDevice::get_instance_proc_addr() {
  return [](VkInstance, const char* name) { return DryFunctions::Find(name); };
}

VkImageView DryDevice::AddImage(const Image& image) {
  views_.push_back(images_.size());
  images_.push_back(image);
  return ToHandle<VkImageView>(views_.size() - 1);
}

size_t DryDevice::ImageOf(VkImageView view) const {
  return views_[ToIndex(view)];
}

size_t DryDevice::IndexOf(VkBuffer buffer) {
  return ToIndex(buffer);
}

}  // namespace stillray::gpu
