// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/future.h"

#include <optional>
#include <utility>
#include <vector>

#include "denoise/next_motion.h"
#include "sequence/reader.h"

namespace stillray {

FuturePass::FuturePass(const SequenceView& view, Denoiser backward, size_t held, bool ahead,
                       Step step)
    : view_(view), blocks_(std::move(backward), held), ahead_(ahead), step_(std::move(step)) {}

Status FuturePass::PlayBackward(const FutureRange& range) {
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
    // The frame's own motion points back and completes that of the previous frame.
    FrameMotion motion;
    if (continues) {
      motion = MotionTowards(now->frame, next->frame, MotionToNext(*now, *next, view_.layout));
      SwapMotion(&motion, &now->frame);
    }
    const Status accumulated = blocks_.Accumulate(i, now->frame, continues);
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

Status FuturePass::Take(size_t at, FutureLight* future) {
  if (!blocks_.Holds(at)) {
    STILLRAY_RETURN_IF_ERROR(PlayBackward(blocks_.Begin(at, view_.options.files.size())));
  }
  *future = std::move(blocks_.At(at));
  return Status::Ok();
}

}  // namespace stillray
