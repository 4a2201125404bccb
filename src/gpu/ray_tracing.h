// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Hardware ray tracing: its requirements (VK_KHR_ray_tracing_pipeline and the extensions that it
/// depends on), and how to create a device with it.
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
  /// VK_KHR_ray_query too: without it the driver emulates the pipelines on a device without units
  /// that trace rays.
  bool queries = false;
  bool indirect = false;  ///< the number of rays may come from device memory
  uint32_t handle_size = 0;
  uint32_t record_stride = 0;      ///< of a shader binding table with aligned records
  uint32_t scratch_alignment = 0;  ///< of the scratch memory of builds
  uint32_t most_rays = 0;          ///< of one launch
  uint64_t most_triangles = 0;     ///< of one bottom level
  uint64_t most_instances = 0;     ///< of a top level
};

/// Never fails: a device without support yields an empty result.
RayTracing FindRayTracing(const InstanceFunctions& functions, VkPhysicalDevice device);

/// The features to create a device with. Not copied: its parts point to each other.
class RayTracingFeatures {
 public:
  /// The required features, and the optional ones that `offered` has.
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
