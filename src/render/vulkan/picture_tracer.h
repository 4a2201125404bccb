// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Owns the GpuTracer for an image size; recreates it only if a larger size does not fit.
#pragma once

#include <memory>

#include "render/vulkan/gpu_tracer.h"

namespace stillray::render {

struct PictureTracerOptions {
  bool rasterise = true;  ///< rasterise primary hits if the device supports it
  /// Maximum number of pixels in a batch, at least 1; 0: all pixels of the image for which the
  /// device has memory.
  uint32_t most_pixels = 0;
};

class PictureTracer {
 public:
  /// \param device, accel, lights, state  must outlive this
  PictureTracer(gpu::Device* device, const GpuAccel* accel, const GpuLights* lights,
                const SceneState* state, const PictureTracerOptions& options)
      : device_(device), accel_(accel), lights_(lights), state_(state), options_(options) {}

  /// Creates a tracer for an image of this size, or for the largest batch that fits into device
  /// memory; destroys the previous tracer in any case. This recompiles the shaders, and viewers
  /// change their resolution often: call HasRoomFor first.
  /// \return kOutOfMemory; kUnsupported: the device lacks a feature
  /// \param parts  see GpuTracer::Create
  Status Make(int width, int height, const TracerParts& parts);
  /// Whether the current tracer can render an image of this size.
  bool HasRoomFor(int width, int height, const TracerParts& parts) const;

  /// The current tracer; nullptr if the last Make failed.
  GpuTracer* tracer() const { return tracer_.get(); }
  /// Whether primary hits can be rasterised.
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
  std::unique_ptr<Visibility> visibility_;  // null: primary rays are traced
  std::unique_ptr<GpuTracer> tracer_;
  bool is_limited_ = false;  // memory limits the batch size of tracer_ to a part of the image
};

/// Width or height of an image, rounded up to whole blocks of a batch.
int RoundUpToBlocks(int pixels);

}  // namespace stillray::render
