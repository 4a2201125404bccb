// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "quality/metrics.h"
#include "quality/row_sums.h"

namespace stillray::quality {
namespace {

double MeanLuminance(const PicturePair& pair, const Image3& image) {
  return MeanOfValid(pair, [&image](int x, int y) { return Luminance(image, x, y); });
}

}  // namespace

double BrightnessRatio(const PicturePair& pair) {
  const double test = MeanLuminance(pair, pair.test);
  const double reference = MeanLuminance(pair, pair.reference);
  if (reference == 0) {
    return test == 0 ? 1.0 : std::numeric_limits<double>::infinity();
  }
  return test / reference;
}

}  // namespace stillray::quality
