// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/shared.h"
#include "denoise/stages/spline_coefficients.h"
#include "denoise/stages/spline_coefficients_shared.h"

namespace stillray::reference {
namespace {

const float kWeights[] = {kSplineWeight0, kSplineWeight1, kSplineWeight2, kSplineWeight3,
                          kSplineWeight4};

/// Filters the values that `load` returns for -kSplineRadius..kSplineRadius.
template <typename Load>
float Filter(const Load& load) {
  float sum = kWeights[0] * load(0);
  for (int k = 1; k <= kSplineRadius; ++k) {
    sum += kWeights[k] * (load(-k) + load(k));
  }
  return sum;
}

}  // namespace

void SplineCoefficients(const Image3& picture, Image3* out) {
  const int width = picture.width();
  const int height = picture.height();
  for (int c = 0; c < 3; ++c) {
    Image1 columns(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        columns(x, y) =
            Filter([&](int k) { return picture[c](x, std::clamp(y + k, 0, height - 1)); });
      }
    }
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        (*out)[c](x, y) =
            Filter([&](int k) { return columns(std::clamp(x + k, 0, width - 1), y); });
      }
    }
  }
}

}  // namespace stillray::reference
