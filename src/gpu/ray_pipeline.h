// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A pipeline that traces rays by hardware, with the table of its shaders.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "gpu/memory.h"

namespace stillray::gpu {

/// SPIR-V of its shaders. Rays are traced from the first one only: what is called never traces.
struct RayPipelineInfo {
  const char* name = "";  ///< for messages
  std::span<const uint32_t> generation;
  std::span<const uint32_t> miss;
  std::span<const uint32_t> closest_hit;  ///< empty: none
  std::span<const uint32_t> any_hit;      ///< empty: none
  std::span<const VkDescriptorSetLayout> sets;
  uint32_t push_bytes = 0;  ///< seen by the first shader
};

/// Not copied or moved.
class RayPipeline {
 public:
  /// Waits for the device: no commands may be in the making.
  /// \param device  that traces rays; must outlive this
  static Result<std::unique_ptr<RayPipeline>> Create(Device* device, const RayPipelineInfo& info);
  RayPipeline(const RayPipeline&) = delete;
  RayPipeline& operator=(const RayPipeline&) = delete;
  ~RayPipeline();

  void Bind(VkCommandBuffer commands, std::span<const VkDescriptorSet> sets, const void* push,
            uint32_t push_bytes) const;
  /// Launches `count` threads of the first shader, numbered along x, of the pipeline that is bound.
  void Trace(VkCommandBuffer commands, uint32_t count) const;
  /// As many as the device finds there, as VkTraceRaysIndirectCommandKHR (RayTracing::indirect).
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
