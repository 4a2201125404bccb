// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Finds the previous position of a pixel's surface point, and compares the guides there.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "doctor/check.h"
#include "stillray/vec.h"

namespace stillray::doctor {

/// Spacing of sampled pixels, chosen so that the work per pair of frames is independent of the
/// resolution.
inline int SampleStep(int width, int height, int64_t samples) {
  int step = 1;
  while (int64_t{width / (step + 1)} * (height / (step + 1)) >= samples) {
    ++step;
  }
  return step;
}

/// The position in `before` of the point visible at pixel (x, y) of `now`, for this motion; samples
/// are offset from their pixel centres by the jitter.
inline vec2 PlaceBefore(const Exhibit& now, const Exhibit& before, int x, int y, vec2 motion) {
  return {static_cast<float>(x) + motion.x + now.frame.jitter_x - before.frame.jitter_x,
          static_cast<float>(y) + motion.y + now.frame.jitter_y - before.frame.jitter_y};
}

inline vec2 MotionAt(const Frame& frame, int x, int y) {
  return {frame.guides.motion[0](x, y), frame.guides.motion[1](x, y)};
}

/// The nearest pixel; false outside the image (or for NaN).
inline bool Nearest(vec2 place, int width, int height, int* x, int* y) {
  if (!(place.x > -0.5f && place.y > -0.5f && place.x < static_cast<float>(width) - 0.5f &&
        place.y < static_cast<float>(height) - 0.5f)) {
    return false;
  }
  *x = static_cast<int>(std::lround(std::max(place.x, 0.0f)));
  *y = static_cast<int>(std::lround(std::max(place.y, 0.0f)));
  return *x < width && *y < height;
}

/// Features that are constant for a moving surface: albedo and normal, or radiance if both are
/// flat.
class Features {
 public:
  explicit Features(const Exhibit& exhibit);

  /// 0 (same surface) to 1 (another surface).
  float Distance(int x, int y, const Features& other, int other_x, int other_y) const;
  /// The smallest distance to the four pixels around a position: textures sampled once per pixel
  /// match one of these pixels, not their mean. 1 outside the image.
  float DistanceAt(int x, int y, const Features& other, vec2 place) const;

  /// Whether the features are guides: radiance also changes where nothing moves.
  bool of_guides() const { return of_guides_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  int width_ = 0;
  int height_ = 0;
  bool of_guides_ = true;
  size_t count_ = 0;
  std::vector<float> values_;  ///< count_ per pixel
};

}  // namespace stillray::doctor
