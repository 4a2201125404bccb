// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/environment.h"

#include <cmath>

#include "core/colour.h"
#include "render/cumulative_sums.h"

namespace stillray::render {
namespace {

/// Mean of the bilinearly interpolated map over a texel: positive wherever the map is not black.
vec3 MeanOverTexel(const EnvironmentArrays& environment, int x, int y) {
  constexpr float kWeight[3] = {0.125f, 0.75f, 0.125f};
  vec3 sum(0.0f);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      sum += FetchEnvironment(environment, x + dx, y + dy) * (kWeight[dx + 1] * kWeight[dy + 1]);
    }
  }
  return sum;
}

}  // namespace

EnvironmentLight::EnvironmentLight(const Environment& environment) {
  arrays_.radiance = environment.radiance;
  arrays_.mean_luminance = Luminance709(environment.radiance);
  arrays_.width = arrays_.height = 0;
  if (environment.map.empty()) {
    return;
  }
  const int width = environment.map.width();
  const int height = environment.map.height();
  arrays_.map = &environment.map;
  arrays_.width = width;
  arrays_.height = height;
  const size_t row_length = static_cast<size_t>(width) + 1;
  const size_t row_count = static_cast<size_t>(height) + 1;
  sums_.resize(row_count + row_length * static_cast<size_t>(height));
  arrays_.sums = sums_.data();
  std::vector<double> rows(row_count, 0.0);
  std::vector<double> columns(row_length, 0.0);
  double solid_angle = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      columns[static_cast<size_t>(x) + 1] =
          columns[static_cast<size_t>(x)] +
          Luminance709(MeanOverTexel(arrays_, x, y) * environment.radiance);
    }
    NormaliseSums(columns, sums_.data() + FirstColumnSum(arrays_, y));
    const double sine = std::sin((y + 0.5) * 3.14159265358979 / height);
    rows[static_cast<size_t>(y) + 1] = rows[static_cast<size_t>(y)] + columns.back() * sine;
    solid_angle += sine * width;
  }
  NormaliseSums(rows, sums_.data());
  arrays_.mean_luminance = static_cast<float>(rows.back() / solid_angle);
}

}  // namespace stillray::render
