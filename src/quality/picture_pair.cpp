// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/picture_pair.h"

#include <cmath>

#include <fmt/core.h>

#include "quality/row_sums.h"

namespace stillray::quality {
namespace {

Status CheckPicture(const Image3& image, const char* name) {
  for (int c = 1; c < 3; ++c) {
    if (image[c].width() != image.width() || image[c].height() != image.height()) {
      return Status::InvalidArgument(
          fmt::format("{} picture: channel {} is {}x{} pixels, channel 0 is {}x{}", name, c,
                      image[c].width(), image[c].height(), image.width(), image.height()));
    }
  }
  if (image.empty()) {
    return Status::InvalidArgument(fmt::format("{} picture: it is empty", name));
  }
  return Status::Ok();
}

bool IsFinite(const Image3& image, int x, int y) {
  return std::isfinite(image[0](x, y)) && std::isfinite(image[1](x, y)) &&
         std::isfinite(image[2](x, y));
}

}  // namespace

Result<PicturePair> MakePicturePair(const Image3& test, const Image3& reference, bool display) {
  STILLRAY_RETURN_IF_ERROR(CheckPicture(test, "test"));
  STILLRAY_RETURN_IF_ERROR(CheckPicture(reference, "reference"));
  if (test.width() != reference.width() || test.height() != reference.height()) {
    return Status::InvalidArgument(
        fmt::format("the test picture is {}x{} pixels, but the reference is {}x{}", test.width(),
                    test.height(), reference.width(), reference.height()));
  }
  PicturePair pair;
  pair.test = test;
  pair.reference = reference;
  pair.valid = Plane<uint8_t>(test.width(), test.height());
  pair.display = display;
  const double valid_count = SumRows(test.height(), [&](int y) {
    int valid_in_row = 0;
    for (int x = 0; x < test.width(); ++x) {
      const bool reference_finite = IsFinite(reference, x, y);
      const bool valid = reference_finite && IsFinite(test, x, y);
      pair.valid(x, y) = valid ? 1 : 0;
      valid_in_row += valid ? 1 : 0;
      for (int c = 0; c < 3 && !valid; ++c) {
        const float stand_in = reference_finite ? reference[c](x, y) : 0.0f;
        pair.test[c](x, y) = stand_in;
        pair.reference[c](x, y) = stand_in;
      }
    }
    return static_cast<double>(valid_in_row);
  });
  pair.valid_count = static_cast<int64_t>(valid_count);
  if (pair.valid_count == 0) {
    return Status::BadData("no pixel is finite in both the test picture and the reference");
  }
  return pair;
}

}  // namespace stillray::quality
