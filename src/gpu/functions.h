// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The Vulkan functions used by stillray, loaded at run time, so that programs start without
/// Vulkan.
///
/// Function tables instead of volk's global function pointers: volk's pointers have the names of
/// Vulkan's functions, hence in a static library they replace the functions that an application
/// links from libvulkan, and they serve a single instance per process, while applications pass
/// their own instance.
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

/// Loaded only with the extension for validation messages.
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

/// Loaded only on devices with ray tracing (gpu/ray_tracing.h).
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

/// Loaded only on devices that share memory (gpu/shared_memory.h).
#define STILLRAY_VK_SHARING_FUNCTIONS(X) X(GetMemoryFdKHR)

/// Loaded only with pipeline statistics (gpu/pipeline_statistics.h).
#define STILLRAY_VK_STATISTICS_FUNCTIONS(X) \
  X(GetPipelineExecutablePropertiesKHR)     \
  X(GetPipelineExecutableStatisticsKHR)

/// Loaded only with VK_EXT_debug_utils (gpu/command_list.h).
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

/// Opens the system's Vulkan loader, which stays open until the program ends.
/// \param library  file name of the loader, or nullptr for the default
/// \return kUnsupported if no loader is found
Result<GlobalFunctions> OpenLoader(const char* library = nullptr);

/// \return kUnsupported naming the first missing function
Result<InstanceFunctions> LoadInstanceFunctions(PFN_vkGetInstanceProcAddr get, VkInstance instance);
/// Loads the core functions; extension functions are loaded separately.
Result<DeviceFunctions> LoadDeviceFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device);
/// Loads the ray tracing functions of a device with the extensions.
Status LoadRayTracingFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device,
                               DeviceFunctions* functions);
/// Loads the memory sharing functions of a device with the extension.
Status LoadSharingFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device,
                            DeviceFunctions* functions);
/// Loads the pipeline statistics functions of a device with the extension.
Status LoadStatisticsFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device,
                               DeviceFunctions* functions);

/// Loads the debug label functions of an instance with the extension.
Status LoadLabelFunctions(PFN_vkGetDeviceProcAddr get, VkDevice device, DeviceFunctions* functions);

/// Converts a VkResult to Ok or to an error such as "allocating image memory: out of device
/// memory".
Status ToStatus(VkResult result, const char* action);

}  // namespace stillray::gpu
