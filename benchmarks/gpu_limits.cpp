// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Properties and limits of all Vulkan devices of the system, as JSON on standard output: needed to
// interpret benchmark results.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "gpu/instance.h"

namespace stillray::gpu {
namespace {

using Json = nlohmann::ordered_json;

std::string VersionText(uint32_t version) {
  return fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

Json LimitsJson(const VkPhysicalDeviceLimits& l) {
  return {
      {"max_compute_work_group_invocations", l.maxComputeWorkGroupInvocations},
      {"max_compute_work_group_size",
       {l.maxComputeWorkGroupSize[0], l.maxComputeWorkGroupSize[1], l.maxComputeWorkGroupSize[2]}},
      {"max_compute_work_group_count",
       {l.maxComputeWorkGroupCount[0], l.maxComputeWorkGroupCount[1],
        l.maxComputeWorkGroupCount[2]}},
      {"max_compute_shared_memory_size", l.maxComputeSharedMemorySize},
      {"max_storage_buffer_range", l.maxStorageBufferRange},
      {"max_image_dimension_2d", l.maxImageDimension2D},
      {"max_per_stage_sampled_images", l.maxPerStageDescriptorSampledImages},
      {"max_per_stage_storage_images", l.maxPerStageDescriptorStorageImages},
      {"max_per_stage_storage_buffers", l.maxPerStageDescriptorStorageBuffers},
      {"max_memory_allocation_count", l.maxMemoryAllocationCount},
      {"buffer_image_granularity", l.bufferImageGranularity},
      {"non_coherent_atom_size", l.nonCoherentAtomSize},
      {"timestamp_period_ns", l.timestampPeriod}};
}

Json MemoryJson(const InstanceFunctions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceMemoryProperties memory = {};
  vk.GetPhysicalDeviceMemoryProperties(device, &memory);
  Json heaps = Json::array();
  for (uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
    heaps.push_back(
        {{"bytes", memory.memoryHeaps[i].size}, {"flags", memory.memoryHeaps[i].flags}});
  }
  Json types = Json::array();
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
    types.push_back({{"heap", memory.memoryTypes[i].heapIndex},
                     {"flags", memory.memoryTypes[i].propertyFlags}});
  }
  return {{"heaps", heaps}, {"types", types}};
}

Json QueuesJson(const InstanceFunctions& vk, VkPhysicalDevice device) {
  uint32_t count = 0;
  vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  Json json = Json::array();
  for (const VkQueueFamilyProperties& family : families) {
    json.push_back({{"flags", family.queueFlags},
                    {"queues", family.queueCount},
                    {"timestamp_bits", family.timestampValidBits}});
  }
  return json;
}

Json ExtensionsJson(const InstanceFunctions& vk, VkPhysicalDevice device) {
  uint32_t count = 0;
  vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data());
  Json json = Json::array();
  for (const VkExtensionProperties& extension : extensions) {
    json.push_back(extension.extensionName);
  }
  return json;
}

Json DeviceJson(const InstanceFunctions& vk, const DeviceInfo& info) {
  VkPhysicalDeviceProperties properties = {};
  vk.GetPhysicalDeviceProperties(info.handle, &properties);
  return {{"device", fmt::format("vulkan:{}", info.index)},
          {"name", info.name},
          {"kind", info.kind},
          {"driver", info.driver},
          {"vulkan", VersionText(info.api_version)},
          {"vendor_id", properties.vendorID},
          {"device_id", properties.deviceID},
          {"usable", info.usable.ok() ? "yes" : info.usable.message()},
          {"ray_tracing_pipelines", info.ray_tracing.offered},
          {"limits", LimitsJson(properties.limits)},
          {"memory", MemoryJson(vk, info.handle)},
          {"queue_families", QueuesJson(vk, info.handle)},
          {"extensions", ExtensionsJson(vk, info.handle)}};
}

Status Run() {
  const Result<std::shared_ptr<Instance>> instance = Instance::Create();
  STILLRAY_RETURN_IF_ERROR(instance.status());
  const Result<std::vector<DeviceInfo>> devices = (*instance)->ListDevices();
  STILLRAY_RETURN_IF_ERROR(devices.status());
  Json json = Json::array();
  for (const DeviceInfo& info : *devices) {
    json.push_back(DeviceJson((*instance)->functions(), info));
  }
  fmt::print("{}\n", Json{{"devices", json}}.dump(2));
  return Status::Ok();
}

}  // namespace
}  // namespace stillray::gpu

int main() {
  const stillray::Status status = stillray::gpu::Run();
  if (!status.ok()) {
    fmt::print(stderr, "gpu_limits: error: {}\n", status.message());
    return 2;
  }
  return EXIT_SUCCESS;
}
