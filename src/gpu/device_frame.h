// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The images of a frame that a renderer leaves on its device: written by its shaders, read by the
/// denoiser's, and brought to the host only where somebody asks for them.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include "gpu/memory.h"
#include "stillray/frame.h"

namespace stillray::gpu {

/// Direct and indirect, diffuse and specular, in the order of SignalKind.
inline constexpr int kFrameSignals = 4;

/// What a frame consists of, beside the signals and guides that each has.
struct FrameShape {
  int width = 0;
  int height = 0;
  bool second_moments = false;  ///< of all signals
  bool samples = false;

  friend bool operator==(const FrameShape&, const FrameShape&) = default;
};

/// Images in VK_IMAGE_LAYOUT_GENERAL, all floats of 32 bits: colours and the normal with four
/// channels (the fourth means nothing), motion with two, others with one; `id` an integer. Those
/// that the shape lacks are nullptr.
struct FrameImages {
  std::array<const Image*, kFrameSignals> lights{};
  std::array<const Image*, kFrameSignals> second_moments{};
  const Image* samples = nullptr;
  const Image* emission = nullptr;
  const Image* background = nullptr;
  const Image* depth = nullptr;
  const Image* normal = nullptr;
  const Image* albedo = nullptr;
  const Image* specular_albedo = nullptr;
  const Image* motion = nullptr;
  const Image* id = nullptr;
  const Image* roughness = nullptr;
};

class DeviceFrame final : public FrameOnDevice {
 public:
  /// \return kOutOfMemory, kInvalidArgument where the device has no images of that size
  static Result<std::shared_ptr<DeviceFrame>> Create(std::shared_ptr<Device> device,
                                                     const FrameShape& shape);

  Status Download(uint32_t planes, Frame* host) const override;
  uint64_t bytes() const override;

  const std::shared_ptr<Device>& device() const { return device_; }
  const FrameShape& shape() const { return shape_; }
  const FrameImages& images() const { return images_; }

  /// Records that all images are written anew, whatever was in them, by compute shaders or by
  /// clearing them. Once per frame, before anything else is done with them.
  void RecordBegin(VkCommandBuffer commands) const;
  /// Records that what was written is seen by all that reads later, in other command buffers too.
  void RecordEnd(VkCommandBuffer commands) const;

  // Facts of the pixels, told by who wrote them.
  float samples_per_pixel = 1;      ///< mean of the frame
  bool has_unknown_guides = false;  ///< there are pixels with depth 0 and no sample

 private:
  /// The way of downloads; made with the first.
  struct Staging {
    explicit Staging(const DeviceContext* context) : arena(context) {}
    Arena arena;
    const Buffer* buffer = nullptr;
  };

  DeviceFrame(std::shared_ptr<Device> device, const FrameShape& shape)
      : device_(std::move(device)), shape_(shape), arena_(&device_->context()) {}
  Status AddImages();
  Status MakeStaging() const;

  std::shared_ptr<Device> device_;
  FrameShape shape_;
  Arena arena_;
  FrameImages images_;
  mutable std::mutex download_;  // one at a time
  mutable std::unique_ptr<Staging> staging_;
};

/// The frame's images if they lie on this device; nullptr: they lie elsewhere, or on the host.
const DeviceFrame* FrameOn(const Device& device, const Frame& frame);

}  // namespace stillray::gpu
