// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The environment of a scene, prepared for environment_shared.h.
#pragma once

#include <vector>

#include "render/environment_shared.h"
#include "stillray/scene.h"

namespace stillray::render {

class EnvironmentLight {
 public:
  /// \param environment  must outlive this; checked (CheckScene)
  explicit EnvironmentLight(const Environment& environment);
  EnvironmentLight(const EnvironmentLight&) = delete;
  EnvironmentLight& operator=(const EnvironmentLight&) = delete;

  const EnvironmentArrays& arrays() const { return arrays_; }
  /// The cumulative sums of arrays(): rows, then the columns of each row.
  const std::vector<float>& sums() const { return sums_; }

  /// The environment emits no light.
  bool dark() const { return arrays_.mean_luminance <= 0.0f; }
  vec3 Radiance(vec3 direction) const { return EnvironmentRadiance(arrays_, direction); }
  size_t memory_bytes() const { return sums_.size() * sizeof(float); }

 private:
  EnvironmentArrays arrays_;
  std::vector<float> sums_;
};

}  // namespace stillray::render
