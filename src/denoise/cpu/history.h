// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/plan.h"
#include "denoise/planes.h"

namespace stillray {

/// The state of the denoiser on the CPU between frames: a sequence continues from it with the same
/// bits.
struct History {
  int width = 0;
  int height = 0;
  SequenceProgress progress;
  std::vector<SignalHistory> signals;
  GuidePlanes guides;           ///< of the last frame; of the one in progress while there is one
  GuidePlanes previous_guides;  ///< of the frame before the one in progress
  Image3 picture;               ///< the last finished one
  HeldGuides held;              ///< of frames with incomplete guides; else empty

  History() = default;
  History(int w, int h, size_t signal_count, const HistoryLayout& layout, int border)
      : width(w),
        height(h),
        signals(signal_count,
                SignalHistory(w, h, layout.with_compressed, layout.with_behind, border)),
        picture(w, h) {}

  HistoryLayout layout() const {
    const bool any = !signals.empty();
    return {.with_compressed = any && !signals.front().compressed.empty(),
            .with_behind = any && !signals.front().behind.empty()};
  }
  /// Whether a frame of this size, with so many signals, can continue from it.
  bool Fits(int w, int h, size_t signal_count, const HistoryLayout& wanted) const {
    return width == w && height == h && signals.size() == signal_count && layout() == wanted;
  }
  size_t bytes() const {
    size_t sum = guides.bytes() + previous_guides.bytes() + picture.bytes() + held.bytes();
    for (const SignalHistory& signal : signals) {
      sum += signal.bytes();
    }
    return sum;
  }
};

}  // namespace stillray
