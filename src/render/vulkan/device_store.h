// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Writes a device's results for a batch of pixels to the images of a frame in device memory: the
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

  /// Selects the images of `frame`: reuses its images if they are suitable and not referenced
  /// elsewhere, otherwise allocates new ones. Its host planes become empty. If memory is
  /// insufficient or the device does not support the size, the frame has no images, and active() is
  /// false.
  /// \param previous_normals  whether the frame has Guides::previous_normal
  /// \param images            kinds of virtual guides in the frame
  Status Begin(const RenderSettings& settings, bool previous_normals, const ImageKinds& images,
               const RenderMoment& moment, Frame* frame);
  /// Whether a frame in device memory is being written.
  bool active() const { return target_ != nullptr; }
  /// Records commands that store the results of the batch.
  /// \param instances  GpuAccel::device_instances
  Status Record(VkCommandBuffer commands, GpuTracer* tracer, const gpu::Buffer& instances,
                const GpuBatch& batch, const GpuTracer::Results& stored);
  /// Finishes the frame after all its batches. Does nothing unless active().
  /// \param paths  number of sampled pixels
  Status End(int64_t paths, Frame* frame);
  /// Abandons the current frame.
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
  /// The inputs of a storing shader.
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
