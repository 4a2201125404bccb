// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Ray queries on any Vulkan device: a BVH in storage buffers, traversed by compute shaders, or ray
/// tracing in hardware. The counterpart of Accel (render/accel.h), with the same hits.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "gpu/device.h"
#include "gpu/memory.h"
#include "gpu/pipeline.h"
#include "render/scene_state.h"
#include "render/vulkan/gpu_scene.h"
#include "render/vulkan/hardware_pipelines.h"
#include "render/vulkan/hardware_scene.h"
#include "render/vulkan/tracing_way.h"

namespace stillray::render {

/// Whether the device has ray tracing units. Some drivers emulate ray tracing pipelines on devices
/// without such units, but support ray queries only on devices with them.
bool TracesByUnits(const gpu::DeviceInfo& info);

/// Whether primary hits are rasterised. `kAuto` traces them on GPUs whose driver emulates ray
/// tracing pipelines: these include data centre GPUs with few rasterisation units.
bool DrawsFirstHits(const gpu::DeviceInfo& info, FirstHits wanted);

/// Whether textures are sampled by texture units, provided that the scene's textures fit into
/// images.
bool SamplesTextures(const gpu::DeviceInfo& info, TextureWay wanted);

/// Whether rays are traced by ray tracing pipelines on this device.
/// \return kUnsupported if it is requested and not available
Result<bool> UsesHardware(const gpu::Device& device, TracingWay way);

/// Not thread-safe.
class GpuAccel {
 public:
  /// Builds the BVH and uploads the scene; waits for completion.
  /// \param device  must outlive this
  /// \param state   scene state at its first moment; must outlive this
  /// \return kUnsupported: an array of the scene is larger than the device's storage buffers, or
  ///     the device has too few of them per shader, or lacks the hardware ray tracing that `way`
  ///     requests, or `textures` do not fit into its images; kOutOfMemory
  static Result<std::unique_ptr<GpuAccel>> Create(gpu::Device* device, const SceneState& state,
                                                  TracingWay way = TracingWay::kAuto,
                                                  TextureWay textures = TextureWay::kExact);

  /// Applies the current transforms and vertices of the state's instances. No recorded commands
  /// that use this may be executing. Takes effect on the device by RecordUpdate.
  Status Update();
  void RecordUpdate(VkCommandBuffer commands) const;

  /// First hits, as Accel::Intersect..., including hits of see-through surfaces. No barrier is
  /// recorded: the rays must be visible to the device's shader stages, and readers of the hits must
  /// synchronise with them (DeviceContext::shader_stages).
  /// \param rays  array of `count` GpuRay
  /// \param hits  array of `count` GpuHit; both are storage buffers, which must outlive this
  /// \return kInvalidArgument: a buffer is too small or there are too many rays for one dispatch
  Status RecordFirstHits(VkCommandBuffer commands, const gpu::Buffer& rays, const gpu::Buffer& hits,
                         uint32_t count);
  /// Transmittance of each ray between origin and end, as Accel::Occluded.
  /// \param lights  array of `count` times three floats
  Status RecordTransmittance(VkCommandBuffer commands, const gpu::Buffer& rays,
                             const gpu::Buffer& lights, uint32_t count);

  gpu::MemoryUse memory() const;
  const GpuScene& scene() const { return *scene_; }
  /// GpuInstance of every instance, by index.
  const gpu::Buffer& device_instances() const { return *buffers_[kInstances]; }

  /// Shape of descriptor set 0, for other shaders that include scene.glsl.
  static constexpr gpu::SetShape kSceneShape = {.buffers = 9, .textures = 2};
  /// The specialisation constants of material_lookup.glsl.
  const std::array<uint32_t, 2>& constants() const { return constants_; }
  bool samples_textures() const { return atlas_.has_value(); }
  VkDescriptorSet scene_set() const { return scene_set_; }
  /// Null if rays are traced in compute shaders.
  const HardwareScene* hardware() const { return hardware_.get(); }

 private:
  explicit GpuAccel(gpu::Device* device)
      : device_(device), arena_(&device->context()), sets_(&device->context()) {}
  Status ChooseAtlas(const std::vector<Texture>& textures, TextureWay way);
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
  std::optional<TextureAtlas> atlas_;          // atlas of the sampled textures
  const gpu::Image* texture_image_ = nullptr;  // a single texel if textures are not sampled
  std::array<uint32_t, 2> constants_{};
  gpu::Pipeline first_hits_;
  gpu::Pipeline transmittance_;
  bool use_hardware_ = false;
  std::unique_ptr<HardwareScene> hardware_;
  std::unique_ptr<gpu::RayPipeline> hardware_first_hits_;
  std::unique_ptr<gpu::RayPipeline> hardware_transmittance_;
  VkDescriptorSet scene_set_ = VK_NULL_HANDLE;
  static constexpr size_t kInstances = 3;  // the binding in scene.glsl
  std::array<const gpu::Buffer*, kSceneShape.buffers> buffers_{};
  // Dynamic data: instances, deforming meshes, the top level.
  const gpu::Buffer* staging_ = nullptr;
};

}  // namespace stillray::render
