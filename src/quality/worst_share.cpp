// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
#include <numeric>

#include "quality/metrics.h"

namespace stillray::quality {

double WorstShare(const PicturePair& pair, SquaredErrors errors) {
  if (errors.sum == 0) {
    return 0;
  }
  const auto begin = errors.pixels.begin();
  const auto end = begin + (pair.valid_count + 99) / 100;
  std::nth_element(begin, end - 1, errors.pixels.end(), std::greater<>());
  // The bits of the sum must not depend on the order in which nth_element leaves them.
  std::sort(begin, end, std::greater<>());
  // Rounding must not make it exceed 1.
  return std::min(std::accumulate(begin, end, 0.0) / errors.sum, 1.0);
}

}  // namespace stillray::quality
