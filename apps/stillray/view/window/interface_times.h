// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Responsiveness of the window, for `--report`: the duration of its frames, the longest time
/// without processing events (which users perceive as a freeze), and the latency from input to
/// image.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "stillray/status.h"
#include "view/view_frame.h"

namespace stillray::view {

/// Times are in seconds of one clock, durations in milliseconds.
class InterfaceTimes {
 public:
  void Looked(double now);
  void Drawn(double ms);
  /// \param number  result of ViewEngine::Post
  /// \param made    number of the newest frame before the call
  void Posted(uint64_t number, uint64_t made, double input_at);
  void Shown(const ViewFrame& frame, double now);

  Status Write(const std::string& path) const;

 private:
  /// The oldest settings not yet included in an image.
  struct Question {
    uint64_t number = 0;
    uint64_t made = 0;
    double asked_at = 0;
  };

  int64_t frames_ = 0;
  double slowest_ms_ = 0;
  double sum_ms_ = 0;
  double looked_at_ = -1;
  double longest_gap_ms_ = 0;
  std::optional<Question> question_;
  int64_t answers_ = 0;
  int64_t most_frames_to_answer_ = 0;
  double sum_answer_ms_ = 0;
  double slowest_answer_ms_ = 0;
  uint64_t shown_ = 0;
  double frame_ms_ = 0;  ///< frame time of the last image
  SampleRate rate_;
  float scale_ = 0;
  int64_t rate_changes_ = 0;
  int64_t scale_changes_ = 0;
  int64_t shared_ = 0;  ///< number of images not copied through the host
};

}  // namespace stillray::view
