// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Primary rays and guides on a device: what FindPrimarySurfaces and MakeGuides find on the CPU,
/// but for the light of the background.
#pragma once

#include <memory>

#include "render/camera.h"
#include "render/vulkan/gpu_accel.h"

namespace stillray::render {

class GpuGuideFinder {
 public:
  /// \param device, accel  must outlive this
  static Result<std::unique_ptr<GpuGuideFinder>> Create(gpu::Device* device, const GpuAccel* accel);

  /// Finds the guides of a picture of the view's size, where the instances stand by the last
  /// GpuAccel::RecordUpdate.
  /// \param view, previous  cameras of this and of the last frame, for pictures of one size
  /// \param jitter          where rays pass their pixels, from its centre, in pixels
  /// \param guides          a storage buffer of width * height GpuGuides, row by row, which lives
  ///                        as long as this; who reads it must wait for compute shaders, and what
  ///                        used it before must be waited for: no barrier is recorded for it
  /// \return kInvalidArgument: a size below 1, sizes that differ, or a buffer that is too small
  Status Record(VkCommandBuffer commands, const CameraView& view, const CameraView& previous,
                vec2 jitter, const gpu::Buffer& guides);

 private:
  GpuGuideFinder(gpu::Device* device, const GpuAccel* accel)
      : device_(device), accel_(accel), arena_(&device->context()), sets_(&device->context()) {}
  Status Make();

  gpu::Device* device_;
  const GpuAccel* accel_;
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  gpu::Pipeline pipeline_;
  const gpu::Buffer* frame_ = nullptr;
};

}  // namespace stillray::render
