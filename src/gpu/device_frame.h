// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The images of a frame in device memory: written by the renderer's shaders, read by the
/// denoiser's shaders, and downloaded only on request.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "gpu/memory.h"
#include "stillray/frame.h"

namespace stillray::gpu {

/// Signals of every frame: direct and indirect, diffuse and specular, in the order of SignalKind.
inline constexpr int kFrameSignals = 4;

/// The optional images of a frame, in addition to the signals and guides of every frame.
struct FrameShape {
  int width = 0;
  int height = 0;
  bool second_moments = false;  ///< second moments of all signals
  bool samples = false;
  bool previous_normals = false;
  bool reflection = false;    ///< virtual guides of the reflection
  bool transmission = false;  ///< signals, albedo and virtual guides of transmitted light

  friend bool operator==(const FrameShape&, const FrameShape&) = default;
};

/// Device images of VirtualGuides.
struct VirtualImages {
  const Image* depth = nullptr;
  const Image* normal = nullptr;
  const Image* albedo = nullptr;
  const Image* motion = nullptr;
  const Image* id = nullptr;
};

/// Images in VK_IMAGE_LAYOUT_GENERAL, with 32-bit float channels: four for colours and normals (the
/// fourth is unused), two for motion, one for all others; `id` holds integers. Images that are not
/// in the FrameShape are nullptr.
struct FrameImages {
  std::array<const Image*, kSignalKindCount> lights{};  ///< by SignalKind
  std::array<const Image*, kSignalKindCount> second_moments{};
  const Image* samples = nullptr;
  const Image* emission = nullptr;
  const Image* background = nullptr;
  const Image* depth = nullptr;
  const Image* normal = nullptr;
  const Image* albedo = nullptr;
  const Image* specular_albedo = nullptr;
  const Image* transmission_albedo = nullptr;
  const Image* motion = nullptr;
  const Image* id = nullptr;
  const Image* roughness = nullptr;
  const Image* previous_normal = nullptr;
  VirtualImages reflection;
  VirtualImages refraction;
};

class DeviceFrame final : public FrameOnDevice {
 public:
  /// \return kOutOfMemory; kInvalidArgument if the device does not support images of that size
  static Result<std::shared_ptr<DeviceFrame>> Create(std::shared_ptr<Device> device,
                                                     const FrameShape& shape);

  Status Download(uint32_t planes, Frame* host) const override;
  uint64_t bytes() const override;
  bool has_reflection() const override { return shape_.reflection; }
  bool has_refraction() const override { return shape_.transmission; }

  const std::shared_ptr<Device>& device() const { return device_; }
  const FrameShape& shape() const { return shape_; }
  const FrameImages& images() const { return images_; }
  /// The images of the frame's signals.
  std::span<const Image* const> lights() const {
    return std::span(images_.lights).first(shape_.transmission ? kSignalKindCount : kFrameSignals);
  }

  /// Records a barrier after which compute shaders or clears may overwrite all images, and discards
  /// their content. Call once per frame, before other use.
  void RecordBegin(VkCommandBuffer commands) const;
  /// Records a barrier that makes the writes visible to all later reads, including reads in other
  /// command buffers.
  void RecordEnd(VkCommandBuffer commands) const;

  // Properties of the frame, set by its writer.
  float samples_per_pixel = 1;         ///< mean over the frame
  bool has_incomplete_guides = false;  ///< some pixels have depth 0 and no sample

 private:
  /// The staging buffer of downloads, created by the first download.
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
  mutable std::mutex download_;  // one download at a time
  mutable std::unique_ptr<Staging> staging_;
};

/// The frame's images if they are on this device; nullptr if they are on another device or in host
/// memory.
const DeviceFrame* FrameOn(const Device& device, const Frame& frame);

}  // namespace stillray::gpu
