// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/reader.h"

#include <utility>

#include "core/check.h"
#include "core/clock.h"

namespace stillray {

FrameReader::FrameReader(const SequenceView& view, std::vector<size_t> order, bool to_write,
                         bool ahead)
    : view_(view), order_(std::move(order)), to_write_(to_write), ahead_(ahead) {}

ReadFrame FrameReader::Load(size_t file) const {
  const Clock::time_point start = Clock::now();
  Result<SequenceFrame> frame = LoadFrame(view_.options.files[file], view_, to_write_);
  return {std::move(frame), MillisecondsSince(start)};
}

ReadFrame FrameReader::Next() {
  STILLRAY_CHECK_LT(taken_, order_.size());
  ReadFrame read = reading_.under_way() ? reading_.Take() : Load(order_[taken_]);
  ++taken_;
  if (ahead_ && read.frame.ok() && taken_ < order_.size()) {
    reading_.Start(true, [this, file = order_[taken_]] { return Load(file); });
  }
  return read;
}

}  // namespace stillray
