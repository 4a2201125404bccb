// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Splits frames that a renderer left on the device into the parts that a LayeredDenoiser
/// processes: layers of reflected and of transmitted light, and the rest. See FrameSplit in
/// backend.h.
#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "denoise/backend.h"
#include "denoise/vulkan/device_inputs.h"
#include "denoise/vulkan/layer_passes.h"

namespace stillray::vulkan {

/// A part of a frame, as input of a denoiser on the same device.
class FramePart final : public FrameOnDevice {
 public:
  FrameFacts facts;
  FrameInputs inputs;                               ///< some are images of the whole frame
  std::vector<std::shared_ptr<const void>> owners;  ///< of all inputs
  /// Adds the passes that write the part's own images, before those that read them.
  std::function<Status(gpu::CommandList*)> record;
  ImageRef picture;  ///< set by the denoiser: its output image

  Status Download(uint32_t planes, Frame* host) const override;
  uint64_t bytes() const override { return 0; }  // its images are counted as FrameSplit::memory
};

class LayerSplit final : public FrameSplit {
 public:
  static Result<std::unique_ptr<LayerSplit>> Create(std::shared_ptr<gpu::Device> device);

  Result<Frame> MakeLayer(const Frame& frame, GuideSource source,
                          const Settings& settings) override;
  Result<Frame> MakeRest(const Frame& frame) override;
  void AddTimes(std::vector<StageTime>* times) const override;
  DeviceMemory memory() const override;
  /// The images of a layer of the last frame, for tests; nullptr before the first frame.
  const LayerImages* images(GuideSource source) const;

 private:
  /// The state of a layer.
  struct Layer {
    std::unique_ptr<LayerPasses> passes;  ///< nullptr before the first frame
    std::weak_ptr<FramePart> part;        ///< of the current frame
  };

  explicit LayerSplit(std::shared_ptr<gpu::Device> device) : device_(std::move(device)) {}
  Layer& LayerOf(GuideSource source) {
    return source == GuideSource::kReflection ? reflection_ : refraction_;
  }

  std::shared_ptr<gpu::Device> device_;
  Layer reflection_;
  Layer refraction_;
};

}  // namespace stillray::vulkan
