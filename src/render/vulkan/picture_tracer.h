// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What traces pictures of a size: made anew only where that of another size has no room.
#pragma once

#include <memory>

#include "render/vulkan/gpu_tracer.h"

namespace stillray::render {

struct PictureTracerOptions {
  bool add_by_group = false;  ///< GpuTracer::Create
  bool rasterise = true;      ///< the camera's first hits are drawn, where the device can
};

class PictureTracer {
 public:
  /// \param device, accel, lights, state  must outlive this
  PictureTracer(gpu::Device* device, const GpuAccel* accel, const GpuLights* lights,
                const SceneState* state, const PictureTracerOptions& options)
      : device_(device), accel_(accel), lights_(lights), state_(state), options_(options) {}

  /// Room for a picture of this size, or for as much of it as the device has memory for. What was
  /// there before is gone in any case. A viewer changes its resolution often, and making all of it
  /// anew compiles the shaders again: HasRoomFor comes first.
  /// \return kOutOfMemory; kUnsupported: the device lacks something
  Status Make(int width, int height);
  /// Whether what was made for another picture does for this one.
  bool HasRoomFor(int width, int height) const;

  /// nullptr: the last Make failed.
  GpuTracer* tracer() const { return tracer_.get(); }
  /// Whether the camera's first hits can be drawn.
  bool draws() const { return visibility_ != nullptr; }
  size_t memory_bytes() const {
    return (tracer_ ? tracer_->memory().bytes : 0) + (draws() ? visibility_->memory().bytes : 0);
  }

 private:
  Status MakeVisibility(int width, int height);

  gpu::Device* device_;
  const GpuAccel* accel_;
  const GpuLights* lights_;
  const SceneState* state_;
  PictureTracerOptions options_;
  std::unique_ptr<Visibility> visibility_;  // none: the camera's rays are traced
  std::unique_ptr<GpuTracer> tracer_;
};

/// The side of a picture with the blocks of batches that stick out of it.
int RoundUpToBlocks(int pixels);

}  // namespace stillray::render
