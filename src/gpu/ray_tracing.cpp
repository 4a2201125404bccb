// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/ray_tracing.h"

#include <algorithm>

#include "gpu/extensions.h"

namespace stillray::gpu {
namespace {

bool HasRayQueries(const InstanceFunctions& vk, VkPhysicalDevice device) {
  constexpr std::array kExtension = {VK_KHR_RAY_QUERY_EXTENSION_NAME};
  if (!HasExtensions(vk, device, kExtension)) {
    return false;
  }
  VkPhysicalDeviceRayQueryFeaturesKHR query = {};
  query.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR;
  VkPhysicalDeviceFeatures2 features = {};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &query;
  vk.GetPhysicalDeviceFeatures2(device, &features);
  return query.rayQuery == VK_TRUE;
}

}  // namespace

RayTracing FindRayTracing(const InstanceFunctions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceProperties basic = {};
  vk.GetPhysicalDeviceProperties(device, &basic);
  if (basic.apiVersion < VK_API_VERSION_1_1 || !HasExtensions(vk, device, kRayTracingExtensions)) {
    return {};
  }
  VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipeline = {};
  pipeline.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR;
  VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration = {};
  acceleration.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
  acceleration.pNext = &pipeline;
  VkPhysicalDeviceBufferDeviceAddressFeatures address = {};
  address.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES;
  address.pNext = &acceleration;
  VkPhysicalDeviceFeatures2 features = {};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &address;
  vk.GetPhysicalDeviceFeatures2(device, &features);
  if (pipeline.rayTracingPipeline == VK_FALSE || acceleration.accelerationStructure == VK_FALSE ||
      address.bufferDeviceAddress == VK_FALSE) {
    return {};
  }
  VkPhysicalDeviceRayTracingPipelinePropertiesKHR of_pipeline = {};
  of_pipeline.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR;
  VkPhysicalDeviceAccelerationStructurePropertiesKHR of_acceleration = {};
  of_acceleration.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR;
  of_acceleration.pNext = &of_pipeline;
  VkPhysicalDeviceProperties2 properties = {};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &of_acceleration;
  vk.GetPhysicalDeviceProperties2(device, &properties);

  RayTracing found;
  found.offered = true;
  found.queries = HasRayQueries(vk, device);
  found.indirect = pipeline.rayTracingPipelineTraceRaysIndirect == VK_TRUE;
  found.handle_size = of_pipeline.shaderGroupHandleSize;
  // Both alignments are powers of two, so the larger one is a multiple of the smaller.
  const uint32_t alignment = std::max(
      {of_pipeline.shaderGroupBaseAlignment, of_pipeline.shaderGroupHandleAlignment, uint32_t{1}});
  found.record_stride = (found.handle_size + alignment - 1) / alignment * alignment;
  found.scratch_alignment =
      std::max(of_acceleration.minAccelerationStructureScratchOffsetAlignment, uint32_t{1});
  found.most_rays = of_pipeline.maxRayDispatchInvocationCount;
  found.most_triangles = of_acceleration.maxPrimitiveCount;
  found.most_instances = of_acceleration.maxInstanceCount;
  return found;
}

RayTracingFeatures::RayTracingFeatures(const RayTracing& offered) {
  address_.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES;
  address_.bufferDeviceAddress = VK_TRUE;
  acceleration_.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
  acceleration_.pNext = &address_;
  acceleration_.accelerationStructure = VK_TRUE;
  pipeline_.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR;
  pipeline_.pNext = &acceleration_;
  pipeline_.rayTracingPipeline = VK_TRUE;
  pipeline_.rayTracingPipelineTraceRaysIndirect = offered.indirect ? VK_TRUE : VK_FALSE;
}

}  // namespace stillray::gpu
