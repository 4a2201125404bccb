// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames that a renderer left on the device, in the parts that a LayeredDenoiser denoises: the
/// layer of reflected light, and the rest. See FrameSplit in backend.h.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "denoise/backend.h"
#include "denoise/vulkan/device_inputs.h"
#include "gpu/pipeline.h"
#include "gpu/timestamps.h"

namespace stillray::vulkan {

/// A part of a frame, as the denoiser on the same device reads it.
class FramePart final : public FrameOnDevice {
 public:
  FrameFacts facts;
  FrameInputs inputs;                               ///< some of them images of the whole frame
  std::vector<std::shared_ptr<const void>> owners;  ///< of all inputs
  /// Records the passes that write the part's own images, before those that read them.
  std::function<Status(VkCommandBuffer)> record;
  ImageRef picture;  ///< set by the denoiser: the finished picture

  Status Download(uint32_t planes, Frame* host) const override;
  uint64_t bytes() const override { return 0; }  // its images are counted as FrameSplit::memory
};

/// The images of both parts that differ from those of the frame.
struct LayerImages {
  explicit LayerImages(const gpu::DeviceContext* context) : arena(context) {}

  gpu::Arena arena;
  bool used = false;  ///< their layout is set
  // Of the layer:
  const gpu::Image* depth = nullptr;
  const gpu::Image* normal = nullptr;
  const gpu::Image* motion = nullptr;
  const gpu::Image* id = nullptr;
  const gpu::Image* roughness = nullptr;
  const gpu::Image* albedo = nullptr;
  const gpu::Image* previous_normal = nullptr;  ///< nullptr unless the frame has it
  const gpu::Image* direct_moment = nullptr;    ///< likewise
  const gpu::Image* indirect_moment = nullptr;  ///< likewise
  // Of the rest:
  const gpu::Image* picture_motion = nullptr;
  const gpu::Image* emission = nullptr;
};

class LayerSplit final : public FrameSplit {
 public:
  static Result<std::unique_ptr<LayerSplit>> Create(std::shared_ptr<gpu::Device> device);

  Result<Frame> MakeLayer(const Frame& frame, float virtual_roughness) override;
  Result<Frame> MakeRest(const Frame& frame) override;
  void AddTimes(std::vector<StageTime>* times) const override;
  DeviceMemory memory() const override;
  /// Of the last frame, for tests; nullptr before the first one.
  const LayerImages* images() const { return images_.get(); }

 private:
  enum Pass : size_t { kSelectGuides, kRescaleMoments, kAddLayer, kPassCount };

  explicit LayerSplit(std::shared_ptr<gpu::Device> device)
      : device_(std::move(device)),
        sets_(&device_->context()),
        layer_times_(&device_->context()),
        rest_times_(&device_->context()) {}

  Status Prepare(const gpu::FrameShape& shape);
  Status MakeImages(const gpu::FrameShape& shape);
  Status RecordLayer(VkCommandBuffer commands, const gpu::FrameImages& from,
                     float virtual_roughness);
  Status RecordRest(VkCommandBuffer commands, const gpu::FrameImages& from);
  Status Run(VkCommandBuffer commands, Pass pass, std::span<const ImageRef> images,
             std::span<const std::byte> push);
  void Mark(VkCommandBuffer commands, const char* name, gpu::Timestamps* times);
  void End(VkCommandBuffer commands, gpu::Timestamps* times);

  std::shared_ptr<gpu::Device> device_;
  gpu::DescriptorSets sets_;
  gpu::Timestamps layer_times_;
  gpu::Timestamps rest_times_;
  std::array<std::optional<gpu::Pipeline>, kPassCount> pipelines_;
  gpu::FrameShape shape_;  ///< of the images
  std::shared_ptr<LayerImages> images_;
  std::weak_ptr<FramePart> layer_;  ///< of the frame in progress
};

}  // namespace stillray::vulkan
