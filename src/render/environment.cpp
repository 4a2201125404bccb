// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/environment.h"

#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "render/bsdf_shared.h"
#include "render/geometry.h"

namespace stillray::render {
namespace {

struct Texel {
  float x, y;  // in texels, 0..width, 0..height
};

Texel TexelOf(vec3 direction, int width, int height) {
  const float u = 0.5f + std::atan2(direction.x, -direction.z) * (0.5f * kInvPi);
  const float v = std::acos(clamp(direction.y, -1.0f, 1.0f)) * kInvPi;
  return {u * static_cast<float>(width), v * static_cast<float>(height)};
}

vec3 Fetch(const Image3& map, int x, int y) {
  const int w = map.width();
  const int wrapped = x < 0 ? x + w : (x >= w ? x - w : x);
  const int clamped = std::clamp(y, 0, map.height() - 1);
  return {map[0](wrapped, clamped), map[1](wrapped, clamped), map[2](wrapped, clamped)};
}

vec3 FetchBilinear(const Image3& map, Texel at) {
  const float left = std::floor(at.x - 0.5f);
  const float top = std::floor(at.y - 0.5f);
  const float fx = at.x - 0.5f - left;
  const float fy = at.y - 0.5f - top;
  const int x = std::clamp(static_cast<int>(left), -1, map.width() - 1);
  const int y = std::clamp(static_cast<int>(top), -1, map.height() - 1);
  const vec3 upper = Fetch(map, x, y) * (1.0f - fx) + Fetch(map, x + 1, y) * fx;
  const vec3 lower = Fetch(map, x, y + 1) * (1.0f - fx) + Fetch(map, x + 1, y + 1) * fx;
  return upper * (1.0f - fy) + lower * fy;
}

// Mean over a texel of what bilinear interpolation gives there: positive wherever any light is.
vec3 MeanOverTexel(const Image3& map, int x, int y) {
  constexpr float kWeight[3] = {0.125f, 0.75f, 0.125f};
  vec3 sum(0.0f);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      sum += Fetch(map, x + dx, y + dy) * (kWeight[dx + 1] * kWeight[dy + 1]);
    }
  }
  return sum;
}

// The interval of cumulative `sums` (count + 1 values) that holds u, which becomes the place in it.
int FindInterval(const float* sums, int count, float* u) {
  const float* above = std::upper_bound(sums + 1, sums + count, *u);
  const int i = static_cast<int>(above - sums) - 1;
  const float width = sums[i + 1] - sums[i];
  *u = width > 0.0f ? clamp((*u - sums[i]) / width, 0.0f, 0.99999994f) : 0.5f;
  return i;
}

// Turns sums into fractions of the last one.
void Normalise(const std::vector<double>& sums, float* out) {
  const double last = sums.back();
  for (size_t i = 0; i < sums.size(); ++i) {
    out[i] = static_cast<float>(
        last > 0 ? sums[i] / last : static_cast<double>(i) / static_cast<double>(sums.size() - 1));
  }
}

}  // namespace

EnvironmentLight::EnvironmentLight(const Environment& environment) : environment_(environment) {
  const float constant = Luminance709(environment.radiance);
  if (environment.map.empty()) {
    mean_luminance_ = constant;
    return;
  }
  width_ = environment.map.width();
  height_ = environment.map.height();
  row_sums_.resize(static_cast<size_t>(height_) + 1);
  const size_t row_length = static_cast<size_t>(width_) + 1;
  column_sums_.resize(row_length * static_cast<size_t>(height_));
  std::vector<double> rows(static_cast<size_t>(height_) + 1, 0.0);
  std::vector<double> columns(row_length, 0.0);
  double solid_angle = 0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      columns[static_cast<size_t>(x) + 1] =
          columns[static_cast<size_t>(x)] +
          Luminance709(MeanOverTexel(environment.map, x, y) * environment.radiance);
    }
    Normalise(columns, column_sums_.data() + row_length * static_cast<size_t>(y));
    const double sine = std::sin((y + 0.5) * 3.14159265358979 / height_);
    rows[static_cast<size_t>(y) + 1] = rows[static_cast<size_t>(y)] + columns.back() * sine;
    solid_angle += sine * width_;
  }
  Normalise(rows, row_sums_.data());
  mean_luminance_ = static_cast<float>(rows.back() / solid_angle);
}

vec3 EnvironmentLight::Radiance(vec3 direction) const {
  if (width_ == 0) {
    return environment_.radiance;
  }
  return environment_.radiance *
         FetchBilinear(environment_.map, TexelOf(direction, width_, height_));
}

EnvironmentSample EnvironmentLight::Sample(vec3 normal, float u0, float u1) const {
  EnvironmentSample sample;
  if (width_ == 0) {
    sample.direction = MakeLocalFrame(normal).ToWorld(SampleCosine(u0, u1));
    sample.radiance = environment_.radiance;
    sample.density = Density(normal, sample.direction);
    return sample;
  }
  const int y = FindInterval(row_sums_.data(), height_, &u1);
  const float* columns = column_sums_.data() + static_cast<ptrdiff_t>(y) * (width_ + 1);
  const int x = FindInterval(columns, width_, &u0);
  const float phi = ((static_cast<float>(x) + u0) / static_cast<float>(width_) - 0.5f) * 2.0f * kPi;
  const float theta = (static_cast<float>(y) + u1) / static_cast<float>(height_) * kPi;
  const float sine = std::sin(theta);
  sample.direction = {sine * std::sin(phi), std::cos(theta), -sine * std::cos(phi)};
  sample.radiance = Radiance(sample.direction);
  sample.density = Density(normal, sample.direction);
  return sample;
}

float EnvironmentLight::Density(vec3 normal, vec3 direction) const {
  if (width_ == 0) {
    return max(dot(normal, direction), 0.0f) * kInvPi;
  }
  const Texel at = TexelOf(direction, width_, height_);
  const int x = std::clamp(static_cast<int>(at.x), 0, width_ - 1);
  const int y = std::clamp(static_cast<int>(at.y), 0, height_ - 1);
  const float* columns = column_sums_.data() + static_cast<ptrdiff_t>(y) * (width_ + 1);
  const float in_square =
      (columns[x + 1] - columns[x]) * static_cast<float>(width_) *
      (row_sums_[static_cast<size_t>(y) + 1] - row_sums_[static_cast<size_t>(y)]) *
      static_cast<float>(height_);
  const float sine = std::sqrt(max(1.0f - direction.y * direction.y, 0.0f));
  return sine > 0.0f ? in_square / (2.0f * kPi * kPi * sine) : 0.0f;
}

size_t EnvironmentLight::memory_bytes() const {
  return (row_sums_.size() + column_sums_.size()) * sizeof(float);
}

}  // namespace stillray::render
