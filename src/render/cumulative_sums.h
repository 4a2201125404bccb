// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Cumulative distributions of the rows and columns of a picture, for sampling in proportion to its
/// luminance.
#pragma once

#include <cstddef>
#include <vector>

namespace stillray::render {

/// Divides cumulative sums by the last one. Those of a black row, which no sample finds, become
/// evenly spaced.
/// \param sums  ascending, begins with 0; at least two
/// \param out   [out] as many numbers, from 0 to 1
inline void NormaliseSums(const std::vector<double>& sums, float* out) {
  const double last = sums.back();
  for (size_t i = 0; i < sums.size(); ++i) {
    out[i] = static_cast<float>(
        last > 0 ? sums[i] / last : static_cast<double>(i) / static_cast<double>(sums.size() - 1));
  }
}

}  // namespace stillray::render
