// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Cache of estimated motion and its confidence, for frames that are linked more than once:
/// backward, for the look-ahead of several blocks, and forward. Results do not depend on it.
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

  /// \param most  maximum number of frames; the lowest frame numbers are evicted first
  explicit MotionCache(size_t most) : most_(most) {}

  /// Restores motion and confidence of a frame. \return false if they are not in the cache
  bool Restore(Frame* frame, MotionOrigin* origin) const;
  /// Stores motion and confidence of a frame, if its motion was estimated.
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
