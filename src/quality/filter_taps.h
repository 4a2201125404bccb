// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The inner loop of separable filters.
#pragma once

#include <cstddef>
#include <vector>

namespace stillray::quality {

/// out[x] = sum over k, in order, of kernel[k] * in[k * stride + x], for x in 0..width-1. A filter
/// along rows has stride 1, one down columns the distance between rows. Products are rounded before
/// they are added, so the bits are the same on every machine.
void FilterTaps(const float* in, size_t stride, const std::vector<float>& kernel, int width,
                float* out);
void FilterTaps(const double* in, size_t stride, const std::vector<double>& kernel, int width,
                double* out);

}  // namespace stillray::quality
