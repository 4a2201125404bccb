// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/denoise_future.h"

#include <algorithm>
#include <utility>

#include "common/device_option.h"
#include "denoise/denoise_reader.h"

namespace stillray {

FuturePass::FuturePass(const DenoiseOptions& options, const AovLayout& layout, Denoiser backward,
                       size_t held, bool ahead, Step step)
    : options_(options),
      layout_(layout),
      backward_(std::move(backward)),
      held_(held),
      ahead_(ahead),
      step_(std::move(step)) {}

FuturePass::Range FuturePass::RangeFrom(size_t at, size_t files, size_t held) {
  const size_t block_end = std::min((at / kFutureBlock + 1) * kFutureBlock, files);
  return {at, std::min(at + held, block_end), std::min(block_end + kLookAhead, files)};
}

size_t FuturePass::CountSteps(size_t first, size_t files, size_t held) {
  size_t steps = 0;
  for (size_t at = first; at < files;) {
    const Range range = RangeFrom(at, files, held);
    steps += range.look_end - range.begin;
    at = range.end;
  }
  return steps;
}

Status FuturePass::Play(const Range& range) {
  backward_.Reset();
  futures_.clear();
  futures_.resize(range.end - range.begin);
  std::vector<size_t> order;
  for (size_t i = range.look_end; i-- > range.begin;) {
    order.push_back(i);
  }
  FrameReader reader(options_, layout_, order, false, ahead_);
  std::optional<SequenceFrame> next;
  for (const size_t i : order) {
    STILLRAY_RETURN_IF_ERROR(step_(options_.files[i]));
    Result<SequenceFrame> now = reader.Next().frame;
    if (!now.ok()) {
      return now.status();
    }
    // The frame's own motion leads back and is asked for by the frame before.
    Image2 own_motion = now->frame.guides.motion;
    if (next && LinkToPrevious(*now, layout_, &*next) == Link::kContinues) {
      now->frame.guides.motion = MotionToNext(*now, *next, layout_);
    } else {
      backward_.Reset();
    }
    FutureLight future;
    const Status played = backward_.Accumulate(now->frame, &future);
    TellFallBack(backward_, &told_fall_back_);
    if (!played.ok()) {
      return Status(played.code(), options_.files[i].input + ": " + played.message());
    }
    if (i < range.end) {
      futures_[i - range.begin] = std::move(future);
    }
    now->frame.guides.motion = std::move(own_motion);
    KeepGuidesOnly(&*now);
    next = std::move(now.value());
  }
  range_ = range;
  return Status::Ok();
}

Status FuturePass::Take(size_t at, FutureLight* future) {
  if (at < range_.begin || at >= range_.end) {
    range_ = Range();
    STILLRAY_RETURN_IF_ERROR(Play(RangeFrom(at, options_.files.size(), held_)));
  }
  *future = std::move(futures_[at - range_.begin]);
  return Status::Ok();
}

DeviceMemory FuturePass::device_memory() const {
  return backward_.device_memory();
}

size_t FuturePass::memory_bytes() const {
  size_t bytes = backward_.memory_bytes();
  for (const FutureLight& future : futures_) {
    bytes += future.bytes();
  }
  return bytes;
}

}  // namespace stillray
