// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The functions of Vulkan that stillray calls, looked up at run time, so that the program starts
/// on machines without Vulkan.
///
/// Tables of our own rather than volk's global function pointers: those have the names of Vulkan's
/// functions, so that in a static library they replace the functions that an application links from
/// libvulkan, and they serve one instance per process, while an application passes its own.
#pragma once

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#include "stillray/status.h"

namespace stillray::gpu {

#define STILLRAY_VK_GLOBAL_FUNCTIONS(X) \
  X(CreateInstance)                     \
  X(EnumerateInstanceVersion)           \
  X(EnumerateInstanceLayerProperties)   \
  X(EnumerateInstanceExtensionProperties)

#define STILLRAY_VK_INSTANCE_FUNCTIONS(X)      \
  X(DestroyInstance)                           \
  X(EnumeratePhysicalDevices)                  \
  X(GetPhysicalDeviceProperties)               \
  X(GetPhysicalDeviceProperties2)              \
  X(GetPhysicalDeviceFeatures)                 \
  X(GetPhysicalDeviceFeatures2)                \
  X(GetPhysicalDeviceFormatProperties)         \
  X(GetPhysicalDeviceMemoryProperties)         \
  X(GetPhysicalDeviceQueueFamilyProperties)    \
  X(GetPhysicalDeviceExternalBufferProperties) \
  X(EnumerateDeviceExtensionProperties)        \
  X(CreateDevice)                              \
  X(GetDeviceProcAddr)

/// Only there with the extension for messages of the validation layer.
#define STILLRAY_VK_DEBUG_FUNCTIONS(X) \
  X(CreateDebugUtilsMessengerEXT)      \
  X(DestroyDebugUtilsMessengerEXT)

#define STILLRAY_VK_DEVICE_FUNCTIONS(X) \
  X(DestroyDevice)                      \
  X(GetDeviceQueue)                     \
  X(DeviceWaitIdle)                     \
  X(QueueSubmit)                        \
  X(CreateFence)                        \
  X(DestroyFence)                       \
  X(ResetFences)                        \
  X(WaitForFences)                      \
  X(CreateCommandPool)                  \
  X(DestroyCommandPool)                 \
  X(ResetCommandPool)                   \
  X(AllocateCommandBuffers)             \
  X(BeginCommandBuffer)                 \
  X(EndCommandBuffer)                   \
  X(AllocateMemory)                     \
  X(FreeMemory)                         \
  X(MapMemory)                          \
  X(FlushMappedMemoryRanges)            \
  X(InvalidateMappedMemoryRanges)       \
  X(CreateBuffer)                       \
  X(DestroyBuffer)                      \
  X(GetBufferMemoryRequirements)        \
  X(BindBufferMemory)                   \
  X(CreateImage)                        \
  X(DestroyImage)                       \
  X(GetImageMemoryRequirements)         \
  X(BindImageMemory)                    \
  X(CreateImageView)                    \
  X(DestroyImageView)                   \
  X(CreateSampler)                      \
  X(DestroySampler)                     \
  X(CreateShaderModule)                 \
  X(DestroyShaderModule)                \
  X(CreateDescriptorSetLayout)          \
  X(DestroyDescriptorSetLayout)         \
  X(CreateDescriptorPool)               \
  X(DestroyDescriptorPool)              \
  X(ResetDescriptorPool)                \
  X(AllocateDescriptorSets)             \
  X(UpdateDescriptorSets)               \
  X(CreatePipelineLayout)               \
  X(DestroyPipelineLayout)              \
  X(CreatePipelineCache)                \
  X(DestroyPipelineCache)               \
  X(GetPipelineCacheData)               \
  X(CreateComputePipelines)             \
  X(CreateGraphicsPipelines)            \
  X(DestroyPipeline)                    \
  X(CreateRenderPass)                   \
  X(DestroyRenderPass)                  \
  X(CreateFramebuffer)                  \
  X(DestroyFramebuffer)                 \
  X(CreateQueryPool)                    \
  X(DestroyQueryPool)                   \
  X(GetQueryPoolResults)                \
  X(CmdResetQueryPool)                  \
  X(CmdWriteTimestamp)                  \
  X(CmdBindPipeline)                    \
  X(CmdBindDescriptorSets)              \
  X(CmdPushConstants)                   \
  X(CmdBeginRenderPass)                 \
  X(CmdEndRenderPass)                   \
  X(CmdSetViewport)                     \
  X(CmdSetScissor)                      \
  X(CmdDraw)                            \
  X(CmdDispatch)                        \
  X(CmdDispatchIndirect)                \
  X(CmdPipelineBarrier)                 \
  X(CmdCopyBuffer)                      \
  X(CmdCopyBufferToImage)               \
  X(CmdCopyImageToBuffer)               \
  X(CmdClearColorImage)                 \
  X(CmdFillBuffer)                      \
  X(CmdUpdateBuffer)

/// Only there on devices that trace rays (gpu/ray_tracing.h).
#define STILLRAY_VK_RAY_TRACING_FUNCTIONS(X)     \
  X(GetBufferDeviceAddressKHR)                   \
  X(CreateAccelerationStructureKHR)              \
  X(DestroyAccelerationStructureKHR)             \
  X(GetAccelerationStructureBuildSizesKHR)       \
  X(GetAccelerationStructureDeviceAddressKHR)    \
  X(CmdBuildAccelerationStructuresKHR)           \
  X(CmdCopyAccelerationStructureKHR)             \
  X(CmdWriteAccelerationStructuresPropertiesKHR) \
  X(CreateRayTracingPipelinesKHR)                \
  X(GetRayTracingShaderGroupHandlesKHR)          \
  X(CmdTraceRaysKHR)                             \
  X(CmdTraceRaysIndirectKHR)

/// Only there on devices that share memory (gpu/shared_memory.h).
#define STILLRAY_VK_SHARING_FUNCTIONS(X) X(GetMemoryFdKHR)

/// Only there with statistics of pipelines (gpu/pipeline_statistics.h).
#define STILLRAY_VK_STATISTICS_FUNCTIONS(X) \
  X(GetPipelineExecutablePropertiesKHR)     \
  X(GetPipelineExecutableStatisticsKHR)

/// Only there with VK_EXT_debug_utils (gpu/command_list.h).
#define STILLRAY_VK_LABEL_FUNCTIONS(X) \
  X(CmdBeginDebugUtilsLabelEXT)        \
  X(CmdEndDebugUtilsLabelEXT)

#define STILLRAY_VK_MEMBER_(name) PFN_vk##name name = nullptr;

struct GlobalFunctions {
  PFN_vkGetInstanceProcAddr GetInstanceProcAddr = nullptr;
  STILLRAY_VK_GLOBAL_FUNCTIONS(STILLRAY_VK_MEMBER_)
};
struct InstanceFunctions {
  STILLRAY_VK_INSTANCE_FUNCTIONS(STILLRAY_VK_MEMBER_)
  STILLRAY_VK_DEBUG_FUNCTIONS(STILLRAY_VK_MEMBER_)
};
struct DeviceFunctions {
  STILLRAY_VK_DEVICE_FUNCTIONS(STILLRAY_VK_MEMBER_)
  STILLRAY_VK_RAY_TRACING_FUNCTIONS(STILLRAY_VK_MEMBER_)
  STILLRAY_VK_SHARING_FUNCTIONS(STILLRAY_VK_MEMBER_)
  STILLRAY_VK_STATISTICS_FUNCTIONS(STILLRAY_VK_MEMBER_)
  STILLRAY_VK_LABEL_FUNCTIONS(STILLRAY_VK_MEMBER_)
};

#undef STILLRAY_VK_MEMBER_

/// The Vulkan loader of this machine; it stays open until the program ends.
/// \param library  its file name, or nullptr for the usual one
/// \return kUnsupported if there is none
Result<GlobalFunctions> OpenLoader(const char* library = nullptr);

/// \return kUnsupported naming the first function that is missing
Result<InstanceFunctions> LoadInstanceFunctions(PFN_vkGetInstanceProcAddr get, VkInstance instance);
/// Those of extensions are left out.
Result<DeviceFunctions> LoadDeviceFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device);
/// Those for tracing rays, of a device with the extensions.
Status LoadRayTracingFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device,
                               DeviceFunctions* functions);
/// Those for sharing memory, likewise.
Status LoadSharingFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device,
                            DeviceFunctions* functions);
/// Those for statistics of pipelines, likewise.
Status LoadStatisticsFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device,
                               DeviceFunctions* functions);

/// Those for debuggers' labels, of an instance with the extension.
Status LoadLabelFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device, DeviceFunctions* functions);

/// Ok, or an error with a sentence: "allocating image memory: out of device memory".
Status ToStatus(VkResult result, const char* action);

}  // namespace stillray::gpu
