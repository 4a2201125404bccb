// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Tracing rays by hardware: what a device must offer for it (VK_KHR_ray_tracing_pipeline and what
/// that stands on), and how a device is made with it.
#pragma once

#include <array>
#include <cstdint>

#include "gpu/functions.h"

namespace stillray::gpu {

/// What is enabled on a device that traces rays, all of it beside Vulkan 1.1.
inline constexpr std::array kRayTracingExtensions = {
    VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME,     VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME,
    VK_EXT_DESCRIPTOR_INDEXING_EXTENSION_NAME,      VK_KHR_SPIRV_1_4_EXTENSION_NAME,
    VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME};

/// What a device offers for tracing rays; sizes and alignments in bytes.
struct RayTracing {
  bool offered = false;
  bool indirect = false;  ///< the number of rays may be the device's to know
  uint32_t handle_size = 0;
  uint32_t record_stride = 0;      ///< of a table of shaders whose records begin aligned
  uint32_t scratch_alignment = 0;  ///< of the memory that builds work in
  uint32_t most_rays = 0;          ///< of one launch
  uint64_t most_triangles = 0;     ///< of one bottom level
  uint64_t most_instances = 0;     ///< of a top level
};

/// Never fails: a device without it offers nothing.
RayTracing FindRayTracing(const InstanceFunctions& functions, VkPhysicalDevice device);

/// The features to make a device with. Not copied: its parts point to each other.
class RayTracingFeatures {
 public:
  /// All that is needed, and what is optional where `offered` has it.
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
