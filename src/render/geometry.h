// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Small geometric helpers of the path tracer.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "render/shared.h"

namespace stillray::render {

/// A rotation whose third axis is a given normal.
struct LocalFrame {
  vec3 x, y, z;

  vec3 ToLocal(vec3 w) const { return {dot(w, x), dot(w, y), dot(w, z)}; }
  vec3 ToWorld(vec3 w) const { return x * w.x + y * w.y + z * w.z; }
};

/// Duff et al. (2017), "Building an Orthonormal Basis, Revisited".
inline LocalFrame MakeLocalFrame(vec3 n) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  const float b = n.x * n.y * a;
  return {vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
          vec3(b, sign + n.y * n.y * a, -n.y), n};
}

/// v / |v|, or `fallback` where that is not defined.
inline vec3 SafeNormalize(vec3 v, vec3 fallback) {
  const float length2 = dot(v, v);
  return length2 > 1e-30f && length2 < 1e30f ? v * (1.0f / std::sqrt(length2)) : fallback;
}

/// A point off the surface on the side of n, far enough that a ray from there does not meet the
/// surface again: some units in the last place, or a small distance near the origin.
/// Waechter and Binder (2019), "A Fast and Robust Method for Avoiding Self-Intersection".
inline vec3 OffsetPoint(vec3 p, vec3 n) {
  constexpr float kOrigin = 1.0f / 32.0f;
  constexpr float kFloatScale = 1.0f / 65536.0f;
  constexpr float kIntScale = 256.0f;
  const auto offset = [](float position, float normal) {
    if (std::abs(position) < kOrigin) {
      return position + kFloatScale * normal;
    }
    const auto steps = static_cast<int32_t>(kIntScale * normal);
    const auto bits = std::bit_cast<int32_t>(position);
    return std::bit_cast<float>(bits + (position < 0 ? -steps : steps));
  };
  return {offset(p.x, n.x), offset(p.y, n.y), offset(p.z, n.z)};
}

}  // namespace stillray::render
