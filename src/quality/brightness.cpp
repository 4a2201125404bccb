// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "quality/metrics.h"
#include "quality/row_sums.h"

namespace stillray::quality {
namespace {

double MeanLuminance(const PicturePair& pair, const Image3& image) {
  return MeanOfValid(pair, [&image](int x, int y) {
    // In double, since the sum of three large floats may overflow.
    return 0.2126 * image[0](x, y) + 0.7152 * image[1](x, y) + 0.0722 * image[2](x, y);
  });
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
