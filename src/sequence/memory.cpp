// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/memory.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "motion/estimate_motion.h"
#include "sequence/motion_cache.h"

namespace stillray {
namespace {

/// Bytes per pixel of frame, histories and working planes, measured and rounded up: 900, and 450
/// for the layer of virtual images that move differently from their surface (io/curved_images.h),
/// which is not known from the header.
constexpr int64_t kBytesPerPixel = 1350;
/// A channel is in memory once as read and once while it is written.
constexpr int64_t kBytesPerChannel = 2 * static_cast<int64_t>(sizeof(float));
/// Window::kBoth: the backward denoiser and its frame, with the same parts.
constexpr int64_t kBytesPerPixelBackward = 1300;

/// Passes: two denoisers of parts, the parts and the new layers; measured and rounded up.
constexpr int64_t kBytesPerPixelOfPasses = 1450;

/// Denoising alpha: a denoiser of one signal and its frame; measured and rounded up. Twice with the
/// backward pass.
constexpr int64_t kBytesPerPixelOfAlpha = 700;

/// Radiance of one future, and its alpha.
int64_t BytesPerPixelOfFuture(const SequenceOptions& options) {
  const int signals = options.denoise_alpha ? 5 : 4;
  return 7 * signals * static_cast<int64_t>(sizeof(float));
}

/// For reading and writing in the background: the frame being read, as a file, as its channels and
/// as planes; the old and new bytes of the one being written, and its channels.
constexpr int64_t kBytesPerChannelOverlapped = 6 * static_cast<int64_t>(sizeof(float));

int64_t BytesNeeded(const ExrExtent& extent, const SequenceOptions& options) {
  int64_t per_pixel = kBytesPerPixel + extent.channels * kBytesPerChannel;
  if (options.window == Window::kBoth) {
    per_pixel += kBytesPerPixelBackward + BytesPerPixelOfFuture(options);
  }
  if (options.passes) {
    per_pixel += kBytesPerPixelOfPasses;
  }
  if (options.denoise_alpha) {
    per_pixel += kBytesPerPixelOfAlpha * (options.window == Window::kBoth ? 2 : 1);
  }
  // For files with motion, this memory is used only if the motion is zero, which is not known yet.
  if (options.motion == MotionSource::kAuto || options.motion == MotionSource::kEstimate) {
    per_pixel += motion::kEstimateBytesPerPixel;
  }
  return extent.pixels * per_pixel;
}

bool Fits(int64_t bytes, const MemoryLimit& limit) {
  return limit.bytes <= 0 || bytes <= limit.bytes;
}

double Megabytes(int64_t bytes) {
  return static_cast<double>(bytes) / 1e6;
}

}  // namespace

Status CheckMemory(const ExrExtent& extent, const SequenceOptions& options,
                   const std::string& name) {
  const int64_t bytes = BytesNeeded(extent, options);
  if (Fits(bytes, options.memory)) {
    return Status::Ok();
  }
  return Status::OutOfMemory(
      fmt::format("{}: a frame of {} x {} pixels with {} channels takes about {:.1f} MB; {} {:.1f} "
                  "MB",
                  name, extent.width, extent.height, extent.channels, Megabytes(bytes),
                  options.memory.name, Megabytes(options.memory.bytes)));
}

namespace {

/// With reading and writing in the background, and the futures of a whole block.
int64_t BytesOverlapped(const ExrExtent& extent, const SequenceOptions& options) {
  int64_t bytes =
      BytesNeeded(extent, options) + extent.pixels * extent.channels * kBytesPerChannelOverlapped;
  if (options.window == Window::kBoth) {
    bytes += (kFutureBlock - 1) * BytesPerPixelOfFuture(options) * extent.pixels;
  }
  return bytes;
}

}  // namespace

bool MotionFits(const ExrExtent& extent, const SequenceOptions& options) {
  const int64_t motion = static_cast<int64_t>(kLinkedFrames) * MotionCache::kBytesPerPixel;
  return Fits(BytesOverlapped(extent, options) + motion * extent.pixels, options.memory);
}

Status OverlapFits(const ExrExtent& extent, const SequenceOptions& options) {
  const int64_t bytes = BytesOverlapped(extent, options);
  if (Fits(bytes, options.memory)) {
    return Status::Ok();
  }
  return Status::OutOfMemory(fmt::format("that would take about {:.1f} MB; {} {:.1f} MB",
                                         Megabytes(bytes), options.memory.name,
                                         Megabytes(options.memory.bytes)));
}

Result<size_t> FuturesThatFit(const ExrExtent& extent, const SequenceOptions& options,
                              const std::string& name) {
  STILLRAY_RETURN_IF_ERROR(CheckMemory(extent, options, name));
  if (options.memory.bytes <= 0) {
    return kFutureBlock;
  }
  // The memory of the frame already includes one.
  const int64_t left = options.memory.bytes - BytesNeeded(extent, options);
  const int64_t each = BytesPerPixelOfFuture(options) * extent.pixels;
  return static_cast<size_t>(std::clamp<int64_t>(1 + left / each, 1, kFutureBlock));
}

void AddDeviceMemory(const DeviceMemory& memory, DeviceMemory* sum) {
  sum->allocations += memory.allocations;
  sum->resources += memory.resources;
  sum->bytes += memory.bytes;
  sum->largest = std::max(sum->largest, memory.largest);
}

}  // namespace stillray
