// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "quality/metrics.h"
#include "stillray/quality.h"

namespace stillray {

ObjectErrors& ObjectErrors::operator+=(const ObjectErrors& other) {
  pixels += other.pixels;
  flip += other.flip;
  rel_mse += other.rel_mse;
  squared_error += other.squared_error;
  luminance += other.luminance;
  reference_luminance += other.reference_luminance;
  return *this;
}

Result<std::vector<ObjectErrors>> CompareObjects(const Image3& test, const Image3& reference,
                                                 bool display, const Image1& objects) {
  const Result<quality::PicturePair> pair = quality::MakePicturePair(test, reference, display);
  STILLRAY_RETURN_IF_ERROR(pair.status());
  if (objects.width() != test.width() || objects.height() != test.height()) {
    return Status::InvalidArgument(fmt::format("the objects are {}x{} pixels, the pictures {}x{}",
                                               objects.width(), objects.height(), test.width(),
                                               test.height()));
  }
  const Image1 flip = quality::FlipErrorMap(*pair, {quality::LdrFlipExposure(*pair)});
  const Image1 relative = quality::RelativeSquaredErrorMap(*pair);
  const quality::SquaredErrors squared = quality::FindSquaredErrors(*pair);
  std::map<int64_t, ObjectErrors> sums;
  for (int y = 0; y < pair->height(); ++y) {
    for (int x = 0; x < pair->width(); ++x) {
      if (pair->valid(x, y) == 0 || !std::isfinite(objects(x, y))) {
        continue;
      }
      const int64_t object = std::llround(objects(x, y));
      ObjectErrors& sum = sums[object];
      sum.object = object;
      ++sum.pixels;
      sum.flip += static_cast<double>(flip(x, y));
      sum.rel_mse += static_cast<double>(relative(x, y));
      sum.squared_error +=
          squared.pixels[static_cast<size_t>(y) * static_cast<size_t>(pair->width()) +
                         static_cast<size_t>(x)];
      sum.luminance += quality::Luminance(pair->test, x, y);
      sum.reference_luminance += quality::Luminance(pair->reference, x, y);
    }
  }
  std::vector<ObjectErrors> errors;
  for (const auto& [object, sum] : sums) {
    errors.push_back(sum);
  }
  return errors;
}

}  // namespace stillray
