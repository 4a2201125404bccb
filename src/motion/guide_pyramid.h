// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The guides of a frame as one image of eight channels, in several sizes, for matching two frames.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stillray/frame.h"

namespace stillray::motion {

/// Albedo (3), normal (3), logarithm of depth, and a hash of the id.
inline constexpr int kChannels = 8;
/// Lower channels are compared directly, channels from here on after subtraction of the patch mean:
/// normals rotate with objects, and depth changes with the distance.
inline constexpr int kFirstMeanFree = 3;
inline constexpr int kEndMeanFree = 7;

/// One level. The image is surrounded by copies of its outermost pixels, so that patches partly
/// outside need no tests.
class GuideLevel {
 public:
  /// Width of the border around the image, in pixels.
  static constexpr int kBorder = 12;

  GuideLevel() = default;
  GuideLevel(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  size_t bytes() const { return values_.size() * sizeof(float); }
  /// Channels of the pixel, followed by the channels of the pixels to its right; the pixel may be
  /// in the border.
  const float* At(int x, int y) const { return values_.data() + Index(x, y); }
  float* At(int x, int y) { return values_.data() + Index(x, y); }
  /// Copies the outermost pixels to the border.
  void FillBorder();
  /// Floats from one row to the next.
  ptrdiff_t stride() const { return static_cast<ptrdiff_t>(width_ + 2 * kBorder) * kChannels; }

 private:
  size_t Index(int x, int y) const {
    return static_cast<size_t>((y + kBorder) * (width_ + 2 * kBorder) + x + kBorder) * kChannels;
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<float> values_;
};

/// The guides at full size and at successively halved sizes.
struct GuidePyramid {
  GuideLevel sharp;                ///< the unsmoothed guides
  std::vector<GuideLevel> levels;  ///< smoothed, the finest first; at least one

  size_t bytes() const;
};

/// Converts guides to the unsmoothed full-size level.
/// \param guides  depth and normal; albedo and id are optional. Invalid values count as zero
GuideLevel MakeLevel(const Guides& guides);
GuidePyramid MakePyramid(GuideLevel sharp);

/// The distance of two pixels: the sum of the differences of their channels, at most kMostDistance.
float DistanceOf(const float* a, const float* b);
inline constexpr float kMostDistance = 1.0f;

/// The smallest distance of pixel (x, y) of `now` to the up to four pixels around (u, v) in
/// `before`: guides of one sample are not interpolated. kMostDistance outside of the image.
float DistanceTo(const GuideLevel& now, int x, int y, const GuideLevel& before, float u, float v);

}  // namespace stillray::motion
