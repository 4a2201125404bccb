// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Estimated motion of frames that are linked more than once, with its confidence: backward, for
/// the look-ahead of several blocks, and forward. No bit depends on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "sequence/motion_plan.h"

namespace stillray {

class MotionCache {
 public:
  /// Bytes per pixel of the motion and confidence of one frame.
  static constexpr int64_t kBytesPerPixel = 3 * static_cast<int64_t>(sizeof(float));

  /// \param most  number of frames held; those with the lowest numbers are dropped first
  explicit MotionCache(size_t most) : most_(most) {}

  /// Restores motion and confidence of a frame. \return false if they are not held
  bool Restore(Frame* frame, MotionOrigin* origin) const;
  /// Holds motion and confidence of a frame, if its motion was estimated.
  void Keep(const Frame& frame, const MotionOrigin& origin);

 private:
  struct Entry {
    Image2 motion;
    Image1 confidence;
    MotionOrigin origin;
  };
  size_t most_;
  std::map<int64_t, Entry> entries_;  ///< by the number of the frame
};

}  // namespace stillray
