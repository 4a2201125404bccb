// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Ray queries on any Vulkan device: a BVH of our own in storage buffers, walked by compute
/// shaders, or ray tracing by hardware. The counterpart of Accel (render/accel.h), with the same
/// hits.
#pragma once

#include <array>
#include <memory>

#include "gpu/device.h"
#include "gpu/memory.h"
#include "gpu/pipeline.h"
#include "render/scene_state.h"
#include "render/vulkan/gpu_scene.h"
#include "render/vulkan/hardware_pipelines.h"
#include "render/vulkan/hardware_scene.h"
#include "render/vulkan/tracing_way.h"

namespace stillray::render {

/// Whether rays are traced by hardware on this device.
/// \return kUnsupported: that is asked for and not offered
Result<bool> UsesHardware(const gpu::Device& device, TracingWay way);

/// Not for several threads at once.
class GpuAccel {
 public:
  /// Builds the tree and brings the scene to the device; waits for that.
  /// \param device  must outlive this
  /// \param state   at its first moment; must outlive this
  /// \return kUnsupported: an array of the scene is larger than the device's storage buffers, or
  ///         the device has too few of them per shader, or does not trace rays by hardware as
  ///         `way` asks; kOutOfMemory
  static Result<std::unique_ptr<GpuAccel>> Create(gpu::Device* device, const SceneState& state,
                                                  TracingWay way = TracingWay::kAuto);

  /// Takes over where the state's instances stand now; only the top level is made anew. No work
  /// that was recorded with this may be running. Takes effect on the device by RecordUpdate.
  Status Update();
  void RecordUpdate(VkCommandBuffer commands) const;

  /// First hits, as Accel::Intersect... finds them: of what is see-through as well.
  /// What wrote the rays must be visible to the device's shader stages, and who reads the hits
  /// must wait for them (DeviceContext::shader_stages): no barrier is recorded.
  /// \param rays   `count` times GpuRay, \param hits  `count` times GpuHit; both storage buffers,
  ///               which live as long as this
  /// \return kInvalidArgument: a buffer is too small or there are too many rays for one dispatch
  Status RecordFirstHits(VkCommandBuffer commands, const gpu::Buffer& rays, const gpu::Buffer& hits,
                         uint32_t count);
  /// Light that comes through from each ray's end to its origin, as Accel::Occluded finds it.
  /// \param lights  `count` times three floats
  Status RecordTransmittance(VkCommandBuffer commands, const gpu::Buffer& rays,
                             const gpu::Buffer& lights, uint32_t count);

  gpu::MemoryUse memory() const;
  const GpuScene& scene() const { return *scene_; }

  /// For other shaders that include scene.glsl: its set 0.
  static constexpr gpu::SetShape kSceneShape = {0, 0, 0, 9};
  VkDescriptorSet scene_set() const { return scene_set_; }
  /// Null where rays are traced in compute shaders.
  const HardwareScene* hardware() const { return hardware_.get(); }

 private:
  explicit GpuAccel(gpu::Device* device)
      : device_(device), arena_(&device->context()), sets_(&device->context()) {}
  Status CheckLimits() const;
  Status AddBuffers();
  Status MakePipelines();
  Status MakeHardware();
  Status Record(VkCommandBuffer commands, const gpu::Pipeline& pipeline,
                const gpu::RayPipeline* by_hardware, const gpu::Buffer& rays,
                const gpu::Buffer& results, size_t result_size, uint32_t count);
  void FillStaging();

  gpu::Device* device_;
  std::unique_ptr<GpuScene> scene_;
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  gpu::Pipeline first_hits_;
  gpu::Pipeline transmittance_;
  bool use_hardware_ = false;
  std::unique_ptr<HardwareScene> hardware_;
  std::unique_ptr<gpu::RayPipeline> hardware_first_hits_;
  std::unique_ptr<gpu::RayPipeline> hardware_transmittance_;
  VkDescriptorSet scene_set_ = VK_NULL_HANDLE;
  std::array<const gpu::Buffer*, kSceneShape.buffers> buffers_{};
  const gpu::Buffer* staging_ = nullptr;  // what moves: top nodes, placements, instances
};

}  // namespace stillray::render
