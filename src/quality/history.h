// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The input of the metrics over consecutive frames, and lookups in the previous frame.
#pragma once

#include <array>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::quality {

/// Frames t and t-1 of a test and a reference sequence; the arguments of TemporalError.
struct ConsecutiveFrames {
  const Image3& test;
  const Image3& previous_test;
  const Image3& reference;
  const Image3& previous_reference;
  const Image2& motion;
  const Image1& depth;
  const Image1& previous_depth;
  bool display;

  int width() const { return test.width(); }
  int height() const { return test.height(); }
  bool has_depth() const { return !depth.empty() && !previous_depth.empty(); }

  /// \return kInvalidArgument (an empty image; sizes that differ, naming both images)
  Status Check() const;
};

/// The up to four pixels around a point and their bilinear weights.
struct HistoryTaps {
  struct Tap {
    int x = 0;
    int y = 0;
    double weight = 0;
  };
  std::array<Tap, 4> tap;
  bool visible = false;  ///< if false, there are no taps
};

/// The pixels of frame t-1 around the reprojected position of pixel (x, y) of frame t. Not visible
/// if they lie outside the image or, by the depths, on another surface.
HistoryTaps FindHistory(const ConsecutiveFrames& frames, int x, int y);

}  // namespace stillray::quality
