// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/picture_tracer.h"

#include <algorithm>

#include "gpu/memory_budget.h"

namespace stillray::render {

int RoundUpToBlocks(int pixels) {
  constexpr int kBlock = static_cast<int>(kBlockSize);
  return (pixels + kBlock - 1) / kBlock * kBlock;
}

namespace {

/// A batch takes at most one third of the device's free memory: frames, denoiser and other programs
/// need the remainder.
constexpr uint64_t kShareOfMemory = 3;
constexpr uint32_t kLeastPixels = 1u << 12;
/// Maximum pixels of a batch whose results are copied to the host, which takes up to 0.3 kB of host
/// memory per pixel. An image of 1920x1080 is one batch.
constexpr int64_t kMostPixelsToHost = 1 << 21;

}  // namespace

/// Number of pixels of a batch, if memory suffices.
uint32_t PictureTracer::WantedPixels(int width, int height, const TracerParts& parts) const {
  const int64_t pixels = int64_t{RoundUpToBlocks(width)} * RoundUpToBlocks(height);
  const int64_t most = parts.to_host ? kMostPixelsToHost : int64_t{1} << 31;
  const int64_t chosen = options_.most_pixels > 0 ? int64_t{options_.most_pixels} : most;
  return static_cast<uint32_t>(std::min({pixels, most, chosen}));
}

/// Primary rays are traced if the device cannot rasterise or lacks the memory.
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
  const uint32_t wanted = WantedPixels(width, height, parts);
  tracer_.reset();
  STILLRAY_RETURN_IF_ERROR(MakeVisibility(width, height));
  const uint64_t fit = gpu::FreeMemory(*device_) / kShareOfMemory / GpuTracer::BytesPerPixel(parts);
  auto most =
      static_cast<uint32_t>(std::min<uint64_t>(wanted, std::max<uint64_t>(fit, kLeastPixels)));
  while (true) {
    Result<std::unique_ptr<GpuTracer>> tracer =
        GpuTracer::Create(device_, accel_, lights_, visibility_.get(), most, parts);
    if (tracer.ok()) {
      tracer_ = std::move(*tracer);
      is_limited_ = tracer_->capacity() < wanted;
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
  return drawn && tracer_ != nullptr && tracer_->parts().Include(parts) &&
         (is_limited_ || tracer_->capacity() >= WantedPixels(width, height, parts));
}

}  // namespace stillray::render
