// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A Vulkan ray tracing pipeline with its shader binding table.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "gpu/memory.h"

namespace stillray::gpu {

/// SPIR-V of the shaders. Only the ray generation shader traces rays: there is no recursion.
struct RayPipelineInfo {
  const char* name = "";  ///< for error messages
  std::span<const uint32_t> generation;
  std::span<const uint32_t> miss;
  std::span<const uint32_t> closest_hit;  ///< empty: none
  std::span<const uint32_t> any_hit;      ///< empty: none
  std::span<const VkDescriptorSetLayout> sets;
  uint32_t push_bytes = 0;                   ///< push constants of the ray generation shader
  std::span<const uint32_t> constants = {};  ///< specialisation constants 0, 1, ... of all shaders
};

/// Not copied or moved.
class RayPipeline {
 public:
  /// Creates the pipeline and waits for the device: no command buffer may be in the recording
  /// state.
  /// \param device  must support ray tracing and outlive this
  static Result<std::unique_ptr<RayPipeline>> Create(Device* device, const RayPipelineInfo& info);
  RayPipeline(const RayPipeline&) = delete;
  RayPipeline& operator=(const RayPipeline&) = delete;
  ~RayPipeline();

  void Bind(VkCommandBuffer commands, std::span<const VkDescriptorSet> sets, const void* push,
            uint32_t push_bytes) const;
  /// Records a launch of `count` invocations of the ray generation shader along x. The pipeline
  /// must be bound.
  void Trace(VkCommandBuffer commands, uint32_t count) const;
  /// Records an indirect launch, whose size is a VkTraceRaysIndirectCommandKHR in device memory
  /// (requires RayTracing::indirect).
  void TraceIndirect(VkCommandBuffer commands, VkDeviceAddress count) const;

 private:
  explicit RayPipeline(Device* device) : device_(device), arena_(&device->context()) {}
  Status MakePipeline(const RayPipelineInfo& info);
  Status MakeTable(const char* name);

  Device* device_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  Arena arena_;
  VkStridedDeviceAddressRegionKHR generation_ = {};
  VkStridedDeviceAddressRegionKHR miss_ = {};
  VkStridedDeviceAddressRegionKHR hit_ = {};
  VkStridedDeviceAddressRegionKHR callable_ = {};
};

}  // namespace stillray::gpu
