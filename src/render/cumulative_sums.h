// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Cumulative distributions of the rows and columns of an image, for sampling in proportion to its
/// luminance.
#pragma once

#include <cstddef>
#include <vector>

namespace stillray::render {

/// Divides cumulative sums by their total. The sums of a black row, which is never sampled, become
/// evenly spaced.
/// \param sums  ascending, begins with 0; at least two
/// \param out   [out] CDF from 0 to 1, as many values as `sums`
inline void NormaliseSums(const std::vector<double>& sums, float* out) {
  const double last = sums.back();
  for (size_t i = 0; i < sums.size(); ++i) {
    out[i] = static_cast<float>(
        last > 0 ? sums[i] / last : static_cast<double>(i) / static_cast<double>(sums.size() - 1));
  }
}

}  // namespace stillray::render
