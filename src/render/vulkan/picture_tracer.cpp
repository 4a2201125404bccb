// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/picture_tracer.h"

#include <algorithm>

namespace stillray::render {

int RoundUpToBlocks(int pixels) {
  constexpr int kBlock = static_cast<int>(kBlockSize);
  return (pixels + kBlock - 1) / kBlock * kBlock;
}

namespace {

/// Maximum number of pixels in a batch: enough to fill a large GPU, 0.6 kB each.
constexpr uint32_t kMostPixels = 1u << 19;
constexpr uint32_t kLeastPixels = 1u << 12;

/// Of a batch.
uint32_t WantedPixels(int width, int height) {
  const int64_t pixels = int64_t{RoundUpToBlocks(width)} * RoundUpToBlocks(height);
  return static_cast<uint32_t>(std::min<int64_t>(pixels, kMostPixels));
}

}  // namespace

/// A device that cannot rasterise, or has no memory for it, traces the camera's rays.
Status PictureTracer::MakeVisibility(int width, int height) {
  visibility_.reset();
  if (!options_.rasterise) {
    return Status::Ok();
  }
  Result<std::unique_ptr<Visibility>> visibility =
      Visibility::Create(device_, accel_, *state_, width, height);
  if (visibility.ok()) {
    visibility_ = std::move(*visibility);
    return Status::Ok();
  }
  const StatusCode code = visibility.status().code();
  return code == StatusCode::kUnsupported || code == StatusCode::kOutOfMemory ? Status::Ok()
                                                                              : visibility.status();
}

Status PictureTracer::Make(int width, int height, const TracerParts& parts) {
  uint32_t most = WantedPixels(width, height);
  tracer_.reset();
  STILLRAY_RETURN_IF_ERROR(MakeVisibility(width, height));
  while (true) {
    Result<std::unique_ptr<GpuTracer>> tracer =
        GpuTracer::Create(device_, accel_, lights_, visibility_.get(), most, parts);
    if (tracer.ok()) {
      tracer_ = std::move(*tracer);
      return Status::Ok();
    }
    if (tracer.status().code() != StatusCode::kOutOfMemory || most <= kLeastPixels) {
      return tracer.status();
    }
    most /= 2;
  }
}

bool PictureTracer::HasRoomFor(int width, int height, const TracerParts& parts) const {
  const bool drawn = visibility_ != nullptr ? visibility_->HasRoomFor(width, height)
                                            : !options_.rasterise || !device_->can_draw();
  return drawn && tracer_ != nullptr && tracer_->capacity() >= WantedPixels(width, height) &&
         tracer_->parts().Include(parts);
}

}  // namespace stillray::render
