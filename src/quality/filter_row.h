// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The inner loops of separable filters.
#pragma once

#include <algorithm>
#include <vector>

namespace stillray::quality {

/// out[x] = sum over k of kernel[k] * in[x + k], for x in 0..width-1. `in` has
/// width + kernel.size() - 1 values. The sum runs over k in order, whatever the compiler does.
template <typename T>
void FilterRow(const T* in, const std::vector<T>& kernel, int width, T* out) {
  std::fill_n(out, width, T(0));
  for (size_t k = 0; k < kernel.size(); ++k) {
    const T weight = kernel[k];
    const T* tap = in + k;
    for (int x = 0; x < width; ++x) {
      out[x] += weight * tap[x];
    }
  }
}

/// The same down columns: out[x] = sum over k of kernel[k] * in[k * stride + x].
template <typename T>
void FilterColumns(const T* in, size_t stride, const std::vector<T>& kernel, int width, T* out) {
  std::fill_n(out, width, T(0));
  for (size_t k = 0; k < kernel.size(); ++k) {
    const T weight = kernel[k];
    const T* tap = in + k * stride;
    for (int x = 0; x < width; ++x) {
      out[x] += weight * tap[x];
    }
  }
}

}  // namespace stillray::quality
