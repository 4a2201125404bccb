// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "scene/builtin.h"

namespace stillray {

namespace {

constexpr float kPi = 3.14159265f;

/// Radiance of the sky in a direction of unit length. The sun is a disc of 9 degrees radius with a
/// soft edge: the real sun would be two thousand times as bright and as hard to sample.
vec3 SkyRadiance(vec3 direction) {
  const vec3 zenith(0.24f, 0.42f, 0.80f);
  const vec3 horizon(0.85f, 0.95f, 1.05f);
  const vec3 ground(0.22f, 0.20f, 0.18f);
  const vec3 sun_radiance(78.0f, 66.0f, 50.0f);
  static const vec3 sun_direction = glm::normalize(vec3(-0.65f, 0.75f, 0.55f));
  constexpr float kSunRadius = 9.0f * kPi / 180.0f;
  constexpr float kSunEdge = 4.0f * kPi / 180.0f;
  constexpr float kHorizonBlur = 0.03f;
  const float up = std::max(direction.y, 0.0f);
  const vec3 sky = glm::mix(horizon, zenith, std::pow(up, 0.5f));
  const float above = glm::smoothstep(-kHorizonBlur, kHorizonBlur, direction.y);
  const float angle = std::acos(glm::clamp(glm::dot(direction, sun_direction), -1.0f, 1.0f));
  const float sun = 1.0f - glm::smoothstep(kSunRadius - kSunEdge, kSunRadius, angle);
  const float halo = 0.8f * std::exp(-angle * 4.0f);
  return glm::mix(ground, sky + vec3(1.0f, 0.9f, 0.75f) * halo, above) + sun_radiance * sun;
}

}  // namespace

Environment MakeSky() {
  constexpr int kWidth = 512;
  constexpr int kHeight = 256;
  Environment environment;
  environment.radiance = vec3(1.0f);
  environment.map = Image3(kWidth, kHeight);
  ParallelRows(kHeight, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float theta = kPi * (static_cast<float>(y) + 0.5f) / kHeight;
      for (int x = 0; x < kWidth; ++x) {
        const float phi = 2.0f * kPi * ((static_cast<float>(x) + 0.5f) / kWidth - 0.5f);
        const vec3 direction(std::sin(theta) * std::sin(phi), std::cos(theta),
                             -std::sin(theta) * std::cos(phi));
        const vec3 radiance = SkyRadiance(direction);
        for (int c = 0; c < 3; ++c) {
          environment.map[c](x, y) = radiance[c];
        }
      }
    }
  });
  return environment;
}

}  // namespace stillray
