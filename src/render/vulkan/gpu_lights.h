// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The lights of a scene on a device: descriptor set 1 of the shaders that include lights.glsl.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "gpu/device.h"
#include "gpu/memory.h"
#include "gpu/pipeline.h"
#include "render/lights.h"

namespace stillray::render {

/// Not thread-safe.
class GpuLights {
 public:
  /// Uploads the static data; waits for completion.
  /// \param device, lights  must outlive this; `lights` up to date
  /// \param environment     environment of the scene
  /// \return kUnsupported: an array is larger than the device's storage buffers; kOutOfMemory
  static Result<std::unique_ptr<GpuLights>> Create(gpu::Device* device, const LightSet& lights,
                                                   const Environment& environment);

  /// Applies the current lights. No recorded commands that use this may be executing. Takes effect
  /// on the device by RecordUpdate.
  Status Update();
  void RecordUpdate(VkCommandBuffer commands) const;

  static constexpr gpu::SetShape kShape = {0, 0, 1, 6};
  static constexpr size_t kBufferCount = kShape.uniforms + kShape.buffers;
  VkDescriptorSet set() const { return set_; }
  gpu::MemoryUse memory() const { return arena_.Need(); }

 private:
  GpuLights(gpu::Device* device, const LightSet& lights)
      : device_(device), lights_(lights), arena_(&device->context()), sets_(&device->context()) {}
  Status AddBuffers(const std::vector<float>& texels);

  gpu::Device* device_;
  const LightSet& lights_;
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
  std::array<const gpu::Buffer*, kBufferCount> buffers_{};
  const gpu::Buffer* staging_ = nullptr;  // dynamic data: shapes, entries, areas, punctual lights
};

}  // namespace stillray::render
