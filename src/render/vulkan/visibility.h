// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Primary hits by rasterisation: the visibility buffer of the hybrid renderers of the SVGF papers.
/// It stores one triangle per pixel; positions, normals, motion and materials are looked up from
/// it, so that the guides equal those of traced rays.
#pragma once

#include <memory>
#include <vector>

#include "gpu/raster.h"
#include "render/vulkan/gpu_accel.h"
#include "render/vulkan/visibility_shared.h"

namespace stillray::render {

class Visibility {
 public:
  /// \param device, accel, state  must outlive this
  /// \param width, height  maximum image size
  /// \return kUnsupported: the device cannot rasterise, or not at this size
  static Result<std::unique_ptr<Visibility>> Create(gpu::Device* device, const GpuAccel* accel,
                                                    const SceneState& state, int width, int height);

  bool HasRoomFor(int width, int height) const {
    return width <= picture_->width && height <= picture_->height;
  }
  /// Records the update of triangles() for an image of the view's size, which must fit; later
  /// shaders may read it.
  void Record(VkCommandBuffer commands, const RasterView& view) const;

  /// Two words per pixel, rows from the top: instance and primitive; kNoInstance: no surface.
  const gpu::Buffer& triangles() const { return *triangles_; }
  gpu::MemoryUse memory() const { return arena_.Need(); }

 private:
  struct Draw {
    uint32_t instance;
    uint32_t vertices;
  };

  Visibility(gpu::Device* device, const GpuAccel* accel)
      : device_(device),
        accel_(accel),
        arena_(&device->context()),
        sets_(&device->context()),
        raster_(&device->context()) {}
  Status CheckSize(int width, int height) const;
  Status Build(const SceneState& state, int width, int height);

  gpu::Device* device_;
  const GpuAccel* accel_;
  gpu::Arena arena_;
  gpu::DescriptorSets sets_;
  gpu::Raster raster_;
  std::vector<Draw> draws_;
  const gpu::Image* picture_ = nullptr;
  const gpu::Buffer* triangles_ = nullptr;
};

}  // namespace stillray::render
