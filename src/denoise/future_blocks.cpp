// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/future_blocks.h"

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace stillray {

FutureRange FutureRangeFrom(size_t at, size_t frames, size_t held) {
  const size_t block_end = std::min((at / kFutureBlock + 1) * kFutureBlock, frames);
  return {at, std::min(at + held, block_end), std::min(block_end + kLookAhead, frames)};
}

size_t CountBackwardFrames(size_t first, size_t frames, size_t held) {
  size_t count = 0;
  for (size_t at = first; at < frames;) {
    const FutureRange range = FutureRangeFrom(at, frames, held);
    count += range.look_end - range.begin;
    at = range.end;
  }
  return count;
}

FutureBlocks::FutureBlocks(Denoiser backward, size_t held)
    : backward_(std::move(backward)), held_(held) {}

bool FutureBlocks::Holds(size_t at) const {
  return next_ == range_.begin && at >= range_.begin && at < range_.end;
}

FutureRange FutureBlocks::Begin(size_t at, size_t frames) {
  STILLRAY_CHECK_LT(at, frames);
  range_ = FutureRangeFrom(at, frames, held_);
  next_ = range_.look_end;
  futures_.clear();
  futures_.resize(range_.end - range_.begin);
  return range_;
}

Status FutureBlocks::Accumulate(size_t at, const Frame& frame, bool continues) {
  STILLRAY_CHECK_EQ(at + 1, next_);
  STILLRAY_CHECK_LE(range_.begin, at);
  if (!continues) {
    backward_.Reset();
  }
  FutureLight future;
  STILLRAY_RETURN_IF_ERROR(backward_.Accumulate(frame, &future));
  if (at < range_.end) {
    futures_[at - range_.begin] = std::move(future);
  }
  next_ = at;
  return Status::Ok();
}

void FutureBlocks::Skip(size_t at) {
  STILLRAY_CHECK_EQ(at + 1, next_);
  STILLRAY_CHECK_LE(range_.begin, at);
  next_ = at;
}

FutureLight& FutureBlocks::At(size_t at) {
  STILLRAY_CHECK(Holds(at));
  return futures_[at - range_.begin];
}

void FutureBlocks::Clear() {
  futures_.clear();
  range_ = FutureRange();
  next_ = 0;
}

size_t FutureBlocks::memory_bytes() const {
  size_t bytes = backward_.memory_bytes();
  for (const FutureLight& future : futures_) {
    bytes += future.bytes();
  }
  return bytes;
}

}  // namespace stillray
