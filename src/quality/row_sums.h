// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Sums over images that do not depend on the number of threads.
#pragma once

#include <numeric>
#include <vector>

#include "core/parallel.h"
#include "quality/picture_pair.h"

namespace stillray::quality {

/// Calls row_sum(y) for each row, in parallel, and sums the results from the top down.
template <typename RowSum>
double SumRows(int height, const RowSum& row_sum) {
  constexpr int kBand = 16;
  std::vector<double> sums(static_cast<size_t>(height));
  ParallelRows(height, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      sums[static_cast<size_t>(y)] = row_sum(y);
    }
  });
  return std::accumulate(sums.begin(), sums.end(), 0.0);
}

/// Calls value(x, y) -> double for each valid pixel and returns the mean of the results.
template <typename Value>
double MeanOfValid(const PicturePair& pair, const Value& value) {
  const double sum = SumRows(pair.height(), [&](int y) {
    double row = 0;
    for (int x = 0; x < pair.width(); ++x) {
      row += pair.valid(x, y) != 0 ? value(x, y) : 0.0;
    }
    return row;
  });
  return sum / static_cast<double>(pair.valid_count);
}

}  // namespace stillray::quality
