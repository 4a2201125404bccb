// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <vector>

#include "core/parallel.h"
#include "stillray/image.h"

namespace stillray {

/// Mean over an image: the sum of sum_of_row(y) over all rows, divided by the number of pixels; in
/// double precision and in a fixed order.
/// \param sums  work memory, one element per row
template <typename SumOfRow>
double MeanOfRows(int width, int height, std::vector<double>* sums, const SumOfRow& sum_of_row) {
  sums->resize(static_cast<size_t>(height));
  ParallelRows(height, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      (*sums)[static_cast<size_t>(y)] = sum_of_row(y);
    }
  });
  double total = 0;
  for (const double sum : *sums) {
    total += sum;
  }
  return total / (static_cast<double>(width) * height);
}

/// Mean of the luminance, at least 1e-20.
inline float MeanLuminance(const LumaImage3& light, std::vector<double>* sums) {
  const double mean = MeanOfRows(light.width(), light.height(), sums, [&](int y) {
    const float* row = light[0].Row(y);
    double sum = 0;
    for (int x = 0; x < light.width(); ++x) {
      sum += static_cast<double>(row[x]);
    }
    return sum;
  });
  return static_cast<float>(std::max(mean, 1e-20));
}

}  // namespace stillray
