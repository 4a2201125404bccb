// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/planes.h"

namespace stillray {

/// What a denoiser remembers from frame to frame: all that is needed to go on with the same bits.
struct DenoiserState {
  int width = 0;
  int height = 0;
  bool has_history = false;  ///< `signals` and `guides` hold the last frame
  bool has_picture = false;  ///< `picture` holds the last antialiased output
  bool jittered = false;     ///< some frame since the history began was
  std::vector<SignalHistory> signals;
  GuidePlanes guides;  ///< of the last finished frame; of the present one while it is in progress
  GuidePlanes previous_guides;  ///< of the frame before the one in progress
  Image3 picture;
  HeldGuides held;  ///< of frames that do not know their guides everywhere; else empty
  /// Samples per pixel that have arrived since filtered light was last fed back.
  float feedback_progress = 0;

  DenoiserState() = default;
  DenoiserState(int w, int h, size_t signal_count, bool with_compressed, bool with_behind,
                int border)
      : width(w),
        height(h),
        signals(signal_count, SignalHistory(w, h, with_compressed, with_behind, border)),
        picture(w, h) {}

  size_t bytes() const {
    size_t sum = guides.bytes() + previous_guides.bytes() + picture.bytes() + held.bytes();
    for (const SignalHistory& signal : signals) {
      sum += signal.bytes();
    }
    return sum;
  }
};

}  // namespace stillray
