// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Light from infinitely far away, and how to find its bright parts.
#pragma once

#include <vector>

#include "render/shared.h"
#include "stillray/scene.h"

namespace stillray::render {

struct EnvironmentSample {
  vec3 direction;
  vec3 radiance;
  float density = 0;  ///< per solid angle; 0: there is no sample
};

class EnvironmentLight {
 public:
  /// \param environment  must outlive this; checked (CheckScene)
  explicit EnvironmentLight(const Environment& environment);

  /// No light at all comes from here.
  bool dark() const { return mean_luminance_ <= 0.0f; }
  /// Mean over all directions.
  float mean_luminance() const { return mean_luminance_; }

  vec3 Radiance(vec3 direction) const;

  /// Draws a direction: of a map in proportion to its luminance; of a constant environment in
  /// proportion to the cosine with `normal`. u in [0,1)^2.
  EnvironmentSample Sample(vec3 normal, float u0, float u1) const;
  /// Density of Sample.
  float Density(vec3 normal, vec3 direction) const;

  size_t memory_bytes() const;

 private:
  const Environment& environment_;
  float mean_luminance_ = 0;
  int width_ = 0;  // 0: constant
  int height_ = 0;
  // Cumulative sums from 0 to 1: rows, then the columns of each row (width_ + 1 values).
  std::vector<float> row_sums_;
  std::vector<float> column_sums_;
};

}  // namespace stillray::render
