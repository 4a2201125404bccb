// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Owns the tracer of pictures of a size; recreated only for sizes that do not fit.
#pragma once

#include <memory>

#include "render/vulkan/gpu_tracer.h"

namespace stillray::render {

struct PictureTracerOptions {
  bool rasterise = true;  ///< rasterise the camera's first hits, if the device can
  /// Maximum number of pixels in a batch, at least 1; 0: all of the picture's for which the device
  /// has memory.
  uint32_t most_pixels = 0;
};

class PictureTracer {
 public:
  /// \param device, accel, lights, state  must outlive this
  PictureTracer(gpu::Device* device, const GpuAccel* accel, const GpuLights* lights,
                const SceneState* state, const PictureTracerOptions& options)
      : device_(device), accel_(accel), lights_(lights), state_(state), options_(options) {}

  /// Creates a tracer for a picture of this size, or for as large a batch as the device has memory
  /// for; destroys the previous one in any case. A viewer changes its resolution often, and this
  /// compiles the shaders again, so call HasRoomFor first.
  /// \return kOutOfMemory; kUnsupported: the device lacks a feature
  /// \param parts  as GpuTracer::Create
  Status Make(int width, int height, const TracerParts& parts);
  /// Whether the current tracer can render a picture of this size.
  bool HasRoomFor(int width, int height, const TracerParts& parts) const;

  /// nullptr: the last Make failed.
  GpuTracer* tracer() const { return tracer_.get(); }
  /// Whether the camera's first hits can be rasterised.
  bool draws() const { return visibility_ != nullptr; }
  size_t memory_bytes() const {
    return (tracer_ ? tracer_->memory().bytes : 0) + (draws() ? visibility_->memory().bytes : 0);
  }

 private:
  Status MakeVisibility(int width, int height);
  uint32_t WantedPixels(int width, int height, const TracerParts& parts) const;

  gpu::Device* device_;
  const GpuAccel* accel_;
  const GpuLights* lights_;
  const SceneState* state_;
  PictureTracerOptions options_;
  std::unique_ptr<Visibility> visibility_;  // null: the camera's rays are traced
  std::unique_ptr<GpuTracer> tracer_;
  bool is_limited_ = false;  // tracer_ has as many pixels as there was memory for, not all
};

/// The size of a picture rounded up to whole blocks of a batch.
int RoundUpToBlocks(int pixels);

}  // namespace stillray::render
