// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The scene as Vulkan acceleration structures, for ray tracing pipelines.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gpu/acceleration.h"
#include "gpu/device.h"
#include "gpu/memory.h"
#include "gpu/pipeline.h"
#include "render/vulkan/gpu_scene.h"

namespace stillray::render {

/// Bottom levels over the triangles of the compute shaders' BVH, which are not copied: one for all
/// static instances, one per moving mesh, one per deforming instance. The bottom levels of
/// deforming instances and the top level of the placements are rebuilt on the device when instances
/// move. Opaque and see-through triangles are separate geometries: any-hit shaders run only for
/// see-through ones.
class HardwareScene {
 public:
  /// Builds the bottom levels; waits for completion.
  /// \param device     must support ray tracing
  /// \param triangles  device buffer of the scene's triangles, created with kTriangleUsage
  /// All arguments must outlive this.
  /// \return kUnsupported: more triangles or instances than the device supports; kOutOfMemory
  static Result<std::unique_ptr<HardwareScene>> Create(gpu::Device* device, const GpuScene& scene,
                                                       const gpu::Buffer& triangles);
  static constexpr VkBufferUsageFlags kTriangleUsage =
      VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
      VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;

  /// Applies the scene's placements. Takes effect by RecordUpdate; no commands that use this may be
  /// executing.
  Status Update();
  /// Records the build of the top level, with barriers against earlier and later tracing.
  void RecordUpdate(VkCommandBuffer commands) const;

  /// Shape of the descriptor set of hardware_set.glsl.
  static constexpr gpu::SetShape kShape = {0, 0, 0, 1, 1};
  VkDescriptorSet set() const { return set_; }
  gpu::MemoryUse memory() const;

 private:
  HardwareScene(gpu::Device* device, const GpuScene& scene)
      : device_(device),
        scene_(scene),
        arena_(&device->context()),
        bottom_arena_(&device->context()),
        deforming_arena_(&device->context()),
        sets_(&device->context()) {}
  Status CheckLimits() const;
  Status AddBuffers();
  Status BuildBottoms(const gpu::Buffer& triangles, const std::vector<uint32_t>& order);
  struct BottomBuffers;
  Status RunBuilds(const gpu::Buffer& triangles, const BottomBuffers& buffers,
                   std::vector<gpu::Acceleration>* built);
  Status Compact(std::span<const gpu::Acceleration> loose);
  Status MakeDeforming(const gpu::Buffer& triangles, const std::vector<uint32_t>& order);
  void RecordDeforming(VkCommandBuffer commands) const;
  Status MakeSet();
  VkDeviceAddress BottomOf(const Placement& placement) const;

  gpu::Device* device_;
  const GpuScene& scene_;
  gpu::Arena arena_;
  gpu::Arena bottom_arena_;
  gpu::Arena deforming_arena_;
  gpu::DescriptorSets sets_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  std::vector<gpu::Acceleration> bottoms_;    // bottom levels of the groups that do not deform
  std::vector<gpu::Acceleration> deforming_;  // bottom levels of the deforming groups
  const gpu::Buffer* triangles_ = nullptr;    // inputs of the deforming bottom levels' builds
  const gpu::Buffer* deforming_corners_ = nullptr;
  const gpu::Buffer* deforming_scratch_ = nullptr;
  gpu::Acceleration top_;
  const gpu::Buffer* order_ = nullptr;
  const gpu::Buffer* staging_ = nullptr;    // to be copied on the device
  const gpu::Buffer* instances_ = nullptr;  // VkAccelerationStructureInstanceKHR
  const gpu::Buffer* top_memory_ = nullptr;
  const gpu::Buffer* scratch_ = nullptr;
};

}  // namespace stillray::render
