// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a device found for a batch of pixels, into the images of a frame that stays there: the
/// counterpart of batch_store.h and of SparseFrameWriter.
#pragma once

#include <memory>
#include <optional>

#include "gpu/device_frame.h"
#include "render/vulkan/gpu_tracer.h"
#include "stillray/render.h"

namespace stillray::render {

/// Not for several threads at once. Order of calls for a frame: Begin, Record for its batches, End.
class DeviceStore {
 public:
  explicit DeviceStore(std::shared_ptr<gpu::Device> device)
      : device_(std::move(device)), sets_(&device_->context()) {}

  /// Chooses images for `frame`: those that it comes with, if they suit and nobody else holds them,
  /// or new ones. Planes on the host are given up. Where there is no memory for images, or the
  /// device has none of that size, the frame is left without, and active() is false.
  Status Begin(const RenderSettings& settings, const RenderMoment& moment, Frame* frame);
  /// Whether a frame was begun that stays on the device.
  bool active() const { return target_ != nullptr; }
  /// Records that the batch's guides or light (or both) are stored, as the tracer found them.
  Status Record(VkCommandBuffer commands, GpuTracer* tracer, const GpuBatch& batch, bool guides,
                bool light);
  /// The frame has all its batches. Nothing to do unless active().
  /// \param paths  pixels that have light
  Status End(int64_t paths, Frame* frame);
  /// Gives up a frame that was begun.
  void Drop() { target_.reset(); }

 private:
  enum Shader : size_t {
    kStoreLight,
    kStoreMoments,
    kStoreListed,
    kStoreGuides,
    kStoreColours,
    kShaderCount
  };

  void Clear(VkCommandBuffer commands, const gpu::Image* image, float value) const;
  void RecordBegin(VkCommandBuffer commands);
  Status Run(VkCommandBuffer commands, Shader shader, std::vector<const gpu::Image*> images,
             const gpu::Buffer& values, const gpu::Buffer& listed, const GpuBatch& batch);

  std::shared_ptr<gpu::Device> device_;
  gpu::DescriptorSets sets_;
  bool has_pool_ = false;
  std::array<std::optional<gpu::Pipeline>, kShaderCount> pipelines_;  // made when first needed
  std::shared_ptr<gpu::DeviceFrame> target_;
  bool begun_ = false;  // RecordBegin was called
  RenderSettings settings_;
};

}  // namespace stillray::render
