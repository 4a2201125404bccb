// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Vulkan ray tracing: its requirements (VK_KHR_ray_tracing_pipeline and the extensions that it
/// depends on), and the features for creating a device.
#pragma once

#include <array>
#include <cstdint>

#include "gpu/functions.h"

namespace stillray::gpu {

/// Extensions to enable on a device for ray tracing, beside Vulkan 1.1.
inline constexpr std::array kRayTracingExtensions = {
    VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,     VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME,
    VK_EXT_DESCRIPTOR_INDEXING_EXTENSION_NAME,      VK_KHR_SPIRV_1_4_EXTENSION_NAME,
    VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME};

/// A device's support for ray tracing; sizes and alignments in bytes.
struct RayTracing {
  bool offered = false;
  /// VK_KHR_ray_query is supported; without it the driver emulates the pipelines on a device
  /// without ray tracing units.
  bool queries = false;
  bool indirect = false;  ///< indirect launches are supported
  uint32_t handle_size = 0;
  uint32_t record_stride = 0;      ///< stride of a shader binding table with aligned records
  uint32_t scratch_alignment = 0;  ///< alignment of the scratch memory of builds
  uint32_t most_rays = 0;          ///< maximum rays per launch
  uint64_t most_triangles = 0;     ///< maximum triangles per bottom level
  uint64_t most_instances = 0;     ///< maximum instances per top level
};

/// Queries the support of a device; empty without support. Never fails.
RayTracing FindRayTracing(const InstanceFunctions& functions, VkPhysicalDevice device);

/// The features to enable on a device. Not copied: its members point to each other.
class RayTracingFeatures {
 public:
  /// The required features, and the optional features in `offered`.
  explicit RayTracingFeatures(const RayTracing& offered);
  RayTracingFeatures(const RayTracingFeatures&) = delete;
  RayTracingFeatures& operator=(const RayTracingFeatures&) = delete;

  /// For pNext of VkDeviceCreateInfo.
  const void* chain() const { return &pipeline_; }

 private:
  VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipeline_ = {};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration_ = {};
  VkPhysicalDeviceBufferDeviceAddressFeatures address_ = {};
};

}  // namespace stillray::gpu
