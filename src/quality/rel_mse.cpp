// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Relative squared error as in Rousselle, Knaus and Zwicker, "Adaptive Sampling and Reconstruction
// using Greedy Error Minimization" (2011), with their epsilon of 0.01, which limits the weight of
// black pixels.
#include <algorithm>
#include <limits>

#include "core/parallel.h"
#include "quality/metrics.h"
#include "quality/row_sums.h"

namespace stillray::quality {
namespace {

constexpr double kEpsilon = 0.01;

double RelativeSquaredError(const PicturePair& pair, int x, int y) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const double reference = pair.reference[c](x, y);
    const double difference = pair.test[c](x, y) - reference;
    sum += difference * difference / (reference * reference + kEpsilon);
  }
  return sum / 3.0;
}

}  // namespace

double RelativeMse(const PicturePair& pair) {
  return MeanOfValid(pair, [&pair](int x, int y) { return RelativeSquaredError(pair, x, y); });
}

Image1 RelativeSquaredErrorMap(const PicturePair& pair) {
  // The square of a firefly may exceed float's range.
  constexpr double kLargest = std::numeric_limits<float>::max();
  constexpr int kBand = 16;
  Image1 map(pair.width(), pair.height());
  ParallelRows(pair.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < pair.width(); ++x) {
        map(x, y) = static_cast<float>(std::min(RelativeSquaredError(pair, x, y), kLargest));
      }
    }
  });
  return map;
}

}  // namespace stillray::quality
