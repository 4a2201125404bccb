// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <numeric>

#include "quality/metrics.h"
#include "quality/row_sums.h"

namespace stillray::quality {
namespace {

double SquaredError(const PicturePair& pair, int x, int y) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const double difference = CompressValue(pair.test[c](x, y), pair.display) -
                              CompressValue(pair.reference[c](x, y), pair.display);
    sum += difference * difference;
  }
  return sum;
}

}  // namespace

SquaredErrors FindSquaredErrors(const PicturePair& pair) {
  SquaredErrors errors;
  errors.pixels.resize(static_cast<size_t>(pair.PixelCount()));
  errors.sum = SumRows(pair.height(), [&](int y) {
    double* const row = &errors.pixels[static_cast<size_t>(y) * static_cast<size_t>(pair.width())];
    for (int x = 0; x < pair.width(); ++x) {
      row[x] = SquaredError(pair, x, y);
    }
    return std::accumulate(row, row + pair.width(), 0.0);
  });
  return errors;
}

double Psnr(const PicturePair& pair, const SquaredErrors& errors) {
  return errors.sum > 0
             ? -10.0 * std::log10(errors.sum / static_cast<double>(pair.valid_count) / 3.0)
             : std::numeric_limits<double>::infinity();
}

}  // namespace stillray::quality
