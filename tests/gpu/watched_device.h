// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A renderer's functions of Vulkan that count the calls of an embedded denoiser, and fail on
/// request.
#pragma once

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#include <atomic>
#include <string>
#include <string_view>
#include <vector>

namespace stillray::test::watched {

/// Calls of the device that recording a frame must not make.
inline std::atomic<int> forbidden_calls = 0;
inline std::atomic<uint32_t> memory_calls = 0;
inline std::atomic<int> set_calls = 0;
inline std::atomic<int> pipeline_calls = 0;
inline std::atomic<VkPipelineCache> pipeline_cache = VK_NULL_HANDLE;  ///< of the last of them
inline std::atomic<int> dispatches = 0;
inline std::atomic<int> barriers = 0;        ///< as CallCounts::barriers
inline std::atomic<int> other_commands = 0;  ///< fills, updates, queries
/// Above 0: the call of vkAllocateDescriptorSets after that many less one fails.
inline std::atomic<int> failing_set_call = 0;
/// Labels in the order of their begin; "" is an end.
inline std::vector<std::string> labels;

/// The functions behind.
struct Real {
  PFN_vkGetInstanceProcAddr get_instance = nullptr;
  PFN_vkGetDeviceProcAddr get_device = nullptr;
  PFN_vkAllocateMemory allocate = nullptr;
  PFN_vkQueueSubmit submit = nullptr;
  PFN_vkAllocateDescriptorSets sets = nullptr;
  PFN_vkWaitForFences wait = nullptr;
  PFN_vkCreateComputePipelines pipelines = nullptr;
  PFN_vkCmdDispatch dispatch = nullptr;
  PFN_vkCmdPipelineBarrier barrier = nullptr;
  PFN_vkCmdFillBuffer fill = nullptr;
  PFN_vkCmdUpdateBuffer update = nullptr;
  PFN_vkCmdBeginDebugUtilsLabelEXT begin_label = nullptr;
  PFN_vkCmdEndDebugUtilsLabelEXT end_label = nullptr;
};
inline Real real;

inline VKAPI_ATTR VkResult VKAPI_CALL Allocate(VkDevice d, const VkMemoryAllocateInfo* i,
                                               const VkAllocationCallbacks* a, VkDeviceMemory* m) {
  ++forbidden_calls;
  ++memory_calls;
  return real.allocate(d, i, a, m);
}
inline VKAPI_ATTR VkResult VKAPI_CALL Submit(VkQueue q, uint32_t n, const VkSubmitInfo* s,
                                             VkFence f) {
  ++forbidden_calls;
  return real.submit(q, n, s, f);
}
inline VKAPI_ATTR VkResult VKAPI_CALL AllocateSets(VkDevice d, const VkDescriptorSetAllocateInfo* i,
                                                   VkDescriptorSet* s) {
  ++forbidden_calls;
  ++set_calls;
  if (failing_set_call > 0 && --failing_set_call == 0) {
    return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  }
  return real.sets(d, i, s);
}
inline VKAPI_ATTR VkResult VKAPI_CALL Wait(VkDevice d, uint32_t n, const VkFence* f, VkBool32 all,
                                           uint64_t ns) {
  ++forbidden_calls;
  return real.wait(d, n, f, all, ns);
}
inline VKAPI_ATTR VkResult VKAPI_CALL CreatePipelines(VkDevice d, VkPipelineCache c, uint32_t n,
                                                      const VkComputePipelineCreateInfo* i,
                                                      const VkAllocationCallbacks* a,
                                                      VkPipeline* p) {
  ++forbidden_calls;
  ++pipeline_calls;
  pipeline_cache = c;
  return real.pipelines(d, c, n, i, a, p);
}
inline VKAPI_ATTR void VKAPI_CALL Dispatch(VkCommandBuffer c, uint32_t x, uint32_t y, uint32_t z) {
  ++dispatches;
  real.dispatch(c, x, y, z);
}
inline VKAPI_ATTR void VKAPI_CALL CountBarrier(VkCommandBuffer c, VkPipelineStageFlags from,
                                               VkPipelineStageFlags to, VkDependencyFlags flags,
                                               uint32_t memory_count, const VkMemoryBarrier* memory,
                                               uint32_t buffer_count,
                                               const VkBufferMemoryBarrier* buffers,
                                               uint32_t image_count,
                                               const VkImageMemoryBarrier* images) {
  barriers += memory_count + buffer_count + image_count > 0 ? 1 : 0;
  real.barrier(c, from, to, flags, memory_count, memory, buffer_count, buffers, image_count,
               images);
}
inline VKAPI_ATTR void VKAPI_CALL Fill(VkCommandBuffer c, VkBuffer buffer, VkDeviceSize offset,
                                       VkDeviceSize size, uint32_t value) {
  ++other_commands;
  real.fill(c, buffer, offset, size, value);
}
inline VKAPI_ATTR void VKAPI_CALL Update(VkCommandBuffer c, VkBuffer buffer, VkDeviceSize offset,
                                         VkDeviceSize size, const void* bytes) {
  ++other_commands;
  real.update(c, buffer, offset, size, bytes);
}
inline VKAPI_ATTR void VKAPI_CALL BeginLabel(VkCommandBuffer c, const VkDebugUtilsLabelEXT* label) {
  labels.emplace_back(label->pLabelName);
  real.begin_label(c, label);
}
inline VKAPI_ATTR void VKAPI_CALL EndLabel(VkCommandBuffer c) {
  labels.emplace_back();
  real.end_label(c);
}

template <typename Function>
PFN_vkVoidFunction Replace(PFN_vkVoidFunction found, Function* behind, Function own) {
  *behind = reinterpret_cast<Function>(found);
  return found != nullptr ? reinterpret_cast<PFN_vkVoidFunction>(own) : nullptr;
}

inline VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDevice(VkDevice device, const char* name) {
  const PFN_vkVoidFunction found = real.get_device(device, name);
  const std::string_view text = name;
  return text == "vkAllocateMemory"           ? Replace(found, &real.allocate, &Allocate)
         : text == "vkQueueSubmit"            ? Replace(found, &real.submit, &Submit)
         : text == "vkAllocateDescriptorSets" ? Replace(found, &real.sets, &AllocateSets)
         : text == "vkWaitForFences"          ? Replace(found, &real.wait, &Wait)
         : text == "vkCreateComputePipelines" ? Replace(found, &real.pipelines, &CreatePipelines)
         : text == "vkCmdDispatch"            ? Replace(found, &real.dispatch, &Dispatch)
         : text == "vkCmdPipelineBarrier"     ? Replace(found, &real.barrier, &CountBarrier)
         : text == "vkCmdFillBuffer"          ? Replace(found, &real.fill, &Fill)
         : text == "vkCmdUpdateBuffer"        ? Replace(found, &real.update, &Update)
         : text == "vkCmdBeginDebugUtilsLabelEXT" ? Replace(found, &real.begin_label, &BeginLabel)
         : text == "vkCmdEndDebugUtilsLabelEXT"   ? Replace(found, &real.end_label, &EndLabel)
                                                  : found;
}

inline VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetInstance(VkInstance instance, const char* name) {
  const PFN_vkVoidFunction found = real.get_instance(instance, name);
  return std::string_view(name) == "vkGetDeviceProcAddr"
             ? Replace(found, &real.get_device, &GetDevice)
             : found;
}

/// The entry of a VulkanContext. \param get  of the instance
inline PFN_vkGetInstanceProcAddr Watch(PFN_vkGetInstanceProcAddr get) {
  real.get_instance = get;
  return &GetInstance;
}

}  // namespace stillray::test::watched
