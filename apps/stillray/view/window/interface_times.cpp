// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/interface_times.h"

#include <algorithm>

#include <fmt/format.h>

#include "stillray/io.h"

namespace stillray::view {

void InterfaceTimes::Looked(double now) {
  if (looked_at_ >= 0) {
    longest_gap_ms_ = std::max(longest_gap_ms_, (now - looked_at_) * 1e3);
  }
  looked_at_ = now;
}

void InterfaceTimes::Drawn(double ms) {
  ++frames_;
  slowest_ms_ = std::max(slowest_ms_, ms);
  sum_ms_ += ms;
}

void InterfaceTimes::Posted(uint64_t number, uint64_t made, double input_at) {
  // No response is possible before the first image.
  if (!question_ && shown_ > 0) {
    question_ = Question{number, made, input_at};
  }
}

void InterfaceTimes::Shown(const ViewFrame& frame, double now) {
  if (frame.number == shown_) {
    return;
  }
  if (frame.number < shown_) {
    question_.reset();  // another scene restarts the numbers
  }
  if (shown_ > 0) {
    rate_changes_ += frame.rate == rate_ ? 0 : 1;
    scale_changes_ += frame.scale == scale_ ? 0 : 1;
  }
  shared_ += std::any_of(frame.shared.begin(), frame.shared.end(),
                         [](const auto& picture) { return picture != nullptr; });
  frame_ms_ = frame.cost.total();
  rate_ = frame.rate;
  scale_ = frame.scale;
  shown_ = frame.number;
  if (question_ && frame.posted >= question_->number) {
    const double ms = (now - question_->asked_at) * 1e3;
    ++answers_;
    most_frames_to_answer_ =
        std::max(most_frames_to_answer_,
                 static_cast<int64_t>(frame.number) - static_cast<int64_t>(question_->made));
    sum_answer_ms_ += ms;
    slowest_answer_ms_ = std::max(slowest_answer_ms_, ms);
    question_.reset();
  }
}

Status InterfaceTimes::Write(const std::string& path) const {
  const auto mean = [](double sum, int64_t count) {
    return count > 0 ? sum / static_cast<double>(count) : 0.0;
  };
  const std::string text = fmt::format(
      "{{\"interface_frames\": {}, \"slowest_ms\": {:.2f}, \"mean_ms\": {:.2f}, "
      "\"longest_gap_ms\": {:.2f},\n \"pictures\": {}, \"answers\": {}, "
      "\"most_frames_to_answer\": {}, \"mean_answer_ms\": {:.2f}, \"slowest_answer_ms\": "
      "{:.2f},\n \"frame_ms\": {:.2f}, \"samples\": \"{}\", \"scale\": {:.3f}, \"rate_changes\": "
      "{}, "
      "\"scale_changes\": {}, \"shared_pictures\": {}}}\n",
      frames_, slowest_ms_, mean(sum_ms_, frames_), longest_gap_ms_, shown_, answers_,
      most_frames_to_answer_, mean(sum_answer_ms_, answers_), slowest_answer_ms_, frame_ms_,
      ToText(rate_), scale_, rate_changes_, scale_changes_, shared_);
  return WriteFileAtomically(path, text.data(), text.size());
}

}  // namespace stillray::view
