// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The input of all quality metrics.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/colour.h"
#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::quality {

/// Two images of the same size with finite values.
struct PicturePair {
  Image3 test;
  Image3 reference;
  /// 1 where both images were finite, else 0. Invalid pixels are set to the reference's value, or
  /// black if that is not finite, in both images: means exclude them, and windows of neighbouring
  /// pixels contain no difference.
  Plane<uint8_t> valid;
  int64_t valid_count = 0;  ///< > 0
  /// Display-referred: linear values of 0..1, decoded from sRGB. Otherwise radiance.
  bool display = false;

  int width() const { return test.width(); }
  int height() const { return test.height(); }
  int64_t PixelCount() const { return static_cast<int64_t>(width()) * height(); }
};

/// \return kInvalidArgument (an empty image; sizes that differ, naming both), kBadData (no pixel is
///     finite in both)
Result<PicturePair> MakePicturePair(const Image3& test, const Image3& reference, bool display);

/// The tone curve on which differences in dark and bright regions have comparable weight. Radiance:
/// x / (1 + x); display images: the sRGB encoding, i.e. the values in the file. Both map to 0..1;
/// negative values count as zero.
inline double CompressValue(float value, bool display) {
  // Written so that NaN becomes 0.
  const float positive = value > 0.0f ? value : 0.0f;
  if (display) {
    return SrgbEncode(std::min(positive, 1.0f));
  }
  return static_cast<double>(positive) / (1.0 + static_cast<double>(positive));
}

/// Rec. 709 luminance, in double, since the sum of three large floats may overflow.
inline double Luminance(const Image3& image, int x, int y) {
  return 0.2126 * image[0](x, y) + 0.7152 * image[1](x, y) + 0.0722 * image[2](x, y);
}

/// CompressValue of the luminance.
inline double CompressedLuminance(const Image3& image, int x, int y, bool display) {
  return CompressValue(static_cast<float>(Luminance(image, x, y)), display);
}

}  // namespace stillray::quality
