// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/future.h"

#include <optional>
#include <utility>
#include <vector>

#include "denoise/next_motion.h"
#include "io/fill_depth.h"
#include "sequence/alpha.h"
#include "sequence/memory.h"
#include "sequence/reader.h"

namespace stillray {

FuturePass::FuturePass(const SequenceView& view, Denoiser backward, size_t held, bool ahead,
                       Step step)
    : view_(view), blocks_(std::move(backward), held), ahead_(ahead), step_(std::move(step)) {}

void FuturePass::AddAlpha(Denoiser backward) {
  alpha_.emplace(std::move(backward), blocks_.held());
}

Status FuturePass::AccumulateAlpha(size_t at, const SequenceFrame& frame, bool continues) {
  const bool goes_on = continues && alpha_continues_;
  alpha_continues_ = goes_on || io::IsPartlyTransparent(frame.alpha);
  if (!alpha_continues_) {
    alpha_->Skip(at);
    return Status::Ok();
  }
  return alpha_->Accumulate(at, FrameOfAlpha(frame.frame, frame.alpha), goes_on);
}

Status FuturePass::PlayBackward(const FutureRange& range) {
  alpha_continues_ = false;
  std::vector<size_t> order;
  for (size_t i = range.look_end; i-- > range.begin;) {
    order.push_back(i);
  }
  FrameReader reader(view_, order, false, ahead_);
  std::optional<SequenceFrame> next;
  for (const size_t i : order) {
    STILLRAY_RETURN_IF_ERROR(step_(view_.options.files[i]));
    Result<SequenceFrame> now = reader.Next().frame;
    if (!now.ok()) {
      return now.status();
    }
    const bool continues = next && LinkToPrevious(*now, view_, &*next) == Link::kContinues;
    // The frame's motion points back, and is inverted to complete the motion of the previous frame.
    FrameMotion motion;
    if (continues) {
      motion = MotionTowards(now->frame, next->frame, MotionToNext(*now, *next, view_.layout));
      SwapMotion(&motion, &now->frame);
    }
    Status accumulated = blocks_.Accumulate(i, now->frame, continues);
    if (accumulated.ok() && alpha_) {
      accumulated = AccumulateAlpha(i, *now, continues);
    }
    if (continues) {
      SwapMotion(&motion, &now->frame);
    }
    if (!accumulated.ok()) {
      return Status(accumulated.code(),
                    view_.options.files[i].input + ": " + accumulated.message());
    }
    KeepGuidesOnly(&*now);
    next = std::move(now.value());
  }
  return Status::Ok();
}

Status FuturePass::Take(size_t at, FutureLight* future, FutureLight* alpha) {
  if (!blocks_.Holds(at)) {
    const size_t files = view_.options.files.size();
    if (alpha_) {
      alpha_->Begin(at, files);
    }
    STILLRAY_RETURN_IF_ERROR(PlayBackward(blocks_.Begin(at, files)));
  }
  *future = std::move(blocks_.At(at));
  if (alpha_) {
    *alpha = std::move(alpha_->At(at));
  }
  return Status::Ok();
}

size_t FuturePass::memory_bytes() const {
  return blocks_.memory_bytes() + (alpha_ ? alpha_->memory_bytes() : 0);
}

DeviceMemory FuturePass::device_memory() const {
  DeviceMemory sum = blocks_.backward().device_memory();
  if (alpha_) {
    AddDeviceMemory(alpha_->backward().device_memory(), &sum);
  }
  return sum;
}

}  // namespace stillray
