// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What all measures of quality start from.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/colour.h"
#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::quality {

/// Two pictures of the same size without a value that is not finite.
struct PicturePair {
  Image3 test;
  Image3 reference;
  /// 1 where both pictures were finite, else 0. There both hold the reference's pixel, or black if
  /// that is not finite: the pixel is left out of all means, and looks the same to the windows of
  /// its neighbours in both pictures.
  Plane<uint8_t> valid;
  int64_t valid_count = 0;  ///< > 0
  /// Display-referred: linear values of 0..1, decoded from sRGB. Otherwise radiance.
  bool display = false;

  int width() const { return test.width(); }
  int height() const { return test.height(); }
  int64_t PixelCount() const { return static_cast<int64_t>(width()) * height(); }
};

/// \return kInvalidArgument (an empty picture; sizes that differ, both named), kBadData (no pixel
///         is finite in both)
Result<PicturePair> MakePicturePair(const Image3& test, const Image3& reference, bool display);

/// The curve on which differences count alike in light and shade. Radiance: x / (1 + x); display
/// pictures: the sRGB encoding, so that it gives the values that the file holds. Both map to 0..1;
/// negative light counts as none.
inline double CompressValue(float value, bool display) {
  // Written so that a NaN becomes 0.
  const float positive = value > 0.0f ? value : 0.0f;
  if (display) {
    return SrgbEncode(std::min(positive, 1.0f));
  }
  return static_cast<double>(positive) / (1.0 + static_cast<double>(positive));
}

}  // namespace stillray::quality
