// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "quality/metrics.h"
#include "quality/row_sums.h"

namespace stillray::quality {

double Psnr(const PicturePair& pair) {
  const double squared_error = MeanOfValid(pair, [&pair](int x, int y) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
      const double difference = CompressValue(pair.test[c](x, y), pair.display) -
                                CompressValue(pair.reference[c](x, y), pair.display);
      sum += difference * difference;
    }
    return sum;
  });
  return squared_error > 0 ? -10.0 * std::log10(squared_error / 3.0)
                           : std::numeric_limits<double>::infinity();
}

}  // namespace stillray::quality
