// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Stores a device's results for a batch of pixels in the images of a frame on the device: the
/// counterpart of batch_store.h and of SparseFrameWriter.
#pragma once

#include <memory>
#include <optional>

#include "gpu/device_frame.h"
#include "render/vulkan/gpu_tracer.h"
#include "stillray/render.h"

namespace stillray::render {

/// Not thread-safe. Order of calls for a frame: Begin, Record for its batches, End.
class DeviceStore {
 public:
  explicit DeviceStore(std::shared_ptr<gpu::Device> device)
      : device_(std::move(device)), sets_(&device_->context()) {}

  /// Chooses images for `frame`: its own, if suitable and not referenced elsewhere, or new ones.
  /// Its planes on the host become empty. If there is no memory for images, or the device does not
  /// support the size, the frame has none, and active() is false.
  /// \param previous_normals  the frame has them
  /// \param images            its virtual guides
  Status Begin(const RenderSettings& settings, bool previous_normals, const ImageKinds& images,
               const RenderMoment& moment, Frame* frame);
  /// Whether a frame has begun that stays on the device.
  bool active() const { return target_ != nullptr; }
  /// Records the storing of these results of the batch.
  /// \param instances  GpuAccel::device_instances
  Status Record(VkCommandBuffer commands, GpuTracer* tracer, const gpu::Buffer& instances,
                const GpuBatch& batch, const GpuTracer::Results& stored);
  /// Finishes the frame after all its batches. Does nothing unless active().
  /// \param paths  number of pixels with light
  Status End(int64_t paths, Frame* frame);
  /// Abandons the frame that has begun.
  void Drop() { target_.reset(); }

 private:
  enum Shader : size_t {
    kStoreLight,
    kStoreMoments,
    kStoreListed,
    kStoreGuides,
    kStoreColours,
    kStorePreviousNormals,
    kStoreTransmission,
    kStoreVirtualGuides,
    kShaderCount
  };

  void Clear(VkCommandBuffer commands, const gpu::Image* image, float value) const;
  void RecordBegin(VkCommandBuffer commands);
  Status StoreGuides(VkCommandBuffer commands, const GpuTracer& tracer,
                     const gpu::Buffer& instances, const GpuBatch& batch);
  Status StoreImages(VkCommandBuffer commands, const GpuTracer& tracer, const GpuBatch& batch,
                     const ImageKinds& kinds);
  Status StoreLight(VkCommandBuffer commands, const GpuTracer& tracer, const gpu::Buffer& sums,
                    const GpuBatch& batch);
  /// What a shader reads of the results.
  struct Source {
    std::initializer_list<const gpu::Buffer*> buffers;
    uint32_t first_signal = 0;
    uint32_t first_image = 0;
  };
  Status Run(VkCommandBuffer commands, Shader shader, std::vector<const gpu::Image*> images,
             const Source& source, const GpuBatch& batch);

  std::shared_ptr<gpu::Device> device_;
  gpu::DescriptorSets sets_;
  bool has_pool_ = false;
  std::array<std::optional<gpu::Pipeline>, kShaderCount> pipelines_;  // created when first used
  std::shared_ptr<gpu::DeviceFrame> target_;
  bool begun_ = false;  // RecordBegin was called
  RenderSettings settings_;
};

}  // namespace stillray::render
