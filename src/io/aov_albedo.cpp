// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_albedo.h"

#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "stillray/vec.h"

namespace stillray::io {
namespace {

constexpr int kRowsPerTask = 16;
/// At most this many pixels are fitted.
constexpr int64_t kSamples = 1 << 16;
constexpr int kIterations = 12;
/// Residual below which all samples have the same weight: the rounding of halves, and bump maps
/// that differ between the closures of one surface.
constexpr double kResidualFloor = 0.01;
/// Length of the residual above which the normal belongs to another surface. Measured in Cycles
/// 3.4: below 0.02 on everything that is not a mirror, above 0.1 on all but one in a thousand
/// pixels of glass.
constexpr float kOtherSurface = 0.1f;

vec3 At(const Image3& image, int x, int y) {
  return {image[0](x, y), image[1](x, y), image[2](x, y)};
}

bool IsFinite(vec3 v) {
  return std::isfinite(v.x + v.y + v.z);
}

struct NormalPair {
  vec3 normal;
  vec3 mapped;
};

std::vector<NormalPair> SamplePairs(const Image3& normal, const Image3& mapped) {
  const int width = normal.width();
  const int height = normal.height();
  int step = 1;
  while (int64_t{width / step} * (height / step) > kSamples) {
    ++step;
  }
  std::vector<NormalPair> pairs;
  for (int y = step / 2; y < height; y += step) {
    for (int x = step / 2; x < width; x += step) {
      const NormalPair pair = {At(normal, x, y), At(mapped, x, y)};
      if (IsFinite(pair.normal) && IsFinite(pair.mapped) && pair.normal != vec3(0.0f)) {
        pairs.push_back(pair);
      }
    }
  }
  return pairs;
}

/// The linear map that most normals follow. It is zero in directions that the normals do not span.
mat3 FitMap(const std::vector<NormalPair>& pairs) {
  glm::dmat3 map(0.0);
  for (int i = 0; i < kIterations; ++i) {
    glm::dmat3 products(0.0);
    glm::dmat3 squares(0.0);
    double total = 0;
    for (const NormalPair& pair : pairs) {
      const glm::dvec3 n(pair.normal);
      const glm::dvec3 d(pair.mapped);
      const double residual = i == 0 ? 0 : glm::length(d - map * n);
      const double weight = 1 / ((kResidualFloor + residual) * (kResidualFloor + residual));
      products += glm::outerProduct(weight * d, n);
      squares += glm::outerProduct(weight * n, n);
      total += weight;
    }
    constexpr double kRidge = 1e-6;
    map = products * glm::inverse(squares + glm::dmat3(kRidge * std::max(total, 1e-30)));
  }
  return mat3(map);
}

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
  const mat3 map = FitMap(SamplePairs(normal, albedo_normal));
  std::vector<int64_t> rejected(static_cast<size_t>(normal.height()));
  ParallelRows(normal.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < normal.width(); ++x) {
        const vec3 residual = At(albedo_normal, x, y) - map * At(normal, x, y);
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
