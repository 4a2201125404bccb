// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_albedo.h"

#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "core/pixels.h"
#include "io/camera_fit.h"
#include "stillray/vec.h"

namespace stillray::io {
namespace {

/// Length of the residual above which the normal belongs to another surface. Measured in Cycles
/// 3.4: below 0.02 outside of mirrors, above 0.1 on all but 0.1 % of the pixels of glass.
constexpr float kOtherSurface = 0.1f;

}  // namespace

void AddAlbedo(const Image3& more, float weight, Image3* albedo) {
  if (more.empty()) {
    return;
  }
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < more.height(); ++y) {
      const float* from = more[c].Row(y);
      float* to = (*albedo)[c].Row(y);
      for (int x = 0; x < more.width(); ++x) {
        to[x] += weight * from[x];
      }
    }
  }
}

int64_t RejectRandomAlbedo(const Image3& normal, const Image3& albedo_normal, Image3* albedo) {
  const mat3 map = FitNormalMap(normal, albedo_normal);
  std::vector<int64_t> rejected(static_cast<size_t>(normal.height()));
  ParallelRows(normal.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < normal.width(); ++x) {
        const vec3 residual = VectorAt(albedo_normal, x, y) - map * VectorAt(normal, x, y);
        if (!(glm::length(residual) > kOtherSurface)) {  // the denoiser rejects NaN
          continue;
        }
        for (int c = 0; c < 3; ++c) {
          (*albedo)[c](x, y) = 1;
        }
        ++rejected[static_cast<size_t>(y)];
      }
    }
  });
  int64_t sum = 0;
  for (const int64_t row : rejected) {
    sum += row;
  }
  return sum;
}

}  // namespace stillray::io
