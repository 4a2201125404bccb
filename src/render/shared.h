// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Extends core/shared.h for the renderer's headers that compile as C++ and as GLSL. In C++ their
// declarations are in stillray::render; GLSL has no namespaces.
#ifndef STILLRAY_RENDER_SHARED_H
#define STILLRAY_RENDER_SHARED_H

#ifdef __cplusplus
#include <limits>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/trigonometric.hpp>

#include "core/shared.h"

#define STILLRAY_RENDER_BEGIN namespace stillray::render {
#define STILLRAY_RENDER_END }
// An input parameter, by const reference in C++.
#define SHARED_IN(type) const type&
// An input and output parameter, by reference in C++.
#define SHARED_INOUT(type) type&

namespace stillray::render {
using glm::cos;
using glm::cross;
using glm::floatBitsToInt;
using glm::floor;
using glm::fract;
using glm::intBitsToFloat;
using glm::length;
using glm::log;
using glm::mix;
using glm::normalize;
using glm::sin;
using glm::uvec4;
const float kInfinity = std::numeric_limits<float>::infinity();
}  // namespace stillray::render
#else
#define STILLRAY_RENDER_BEGIN
#define STILLRAY_RENDER_END
#define SHARED_IN(type) type
#define SHARED_INOUT(type) inout type
#define kInfinity uintBitsToFloat(0x7f800000u)
#endif

STILLRAY_RENDER_BEGIN

const float kPi = 3.14159265f;
const float kInvPi = 0.31830989f;
/// FLT_MAX, the largest finite float.
const float kLargestFloat = 3.402823466e38f;
/// The largest number below 1.
const float kBelowOne = 0.99999994f;

/// (cos, sin) of 2 pi u for u in [0, 1): exact range reduction to a quarter turn, then minimax
/// polynomials (S. Moshier's Cephes, sinf and cosf), to 1e-7. Bit-identical with any mathematical
/// library.
SHARED_FN vec2 CosSinOfTurn(float u) {
  int quarter = int(4.0f * u + 0.5f);
  float x = (u - 0.25f * float(quarter)) * (2.0f * kPi);
  float x2 = x * x;
  float s = x + x * x2 * (-1.6666654611e-1f + x2 * (8.3321608736e-3f - 1.9515295891e-4f * x2));
  float c =
      1.0f - 0.5f * x2 +
      x2 * x2 *
          (4.166664568298827e-2f + x2 * (-1.388731625493765e-3f + 2.443315711809948e-5f * x2));
  float near_cos = (quarter & 1) == 0 ? c : s;
  float near_sin = (quarter & 1) == 0 ? s : c;
  return vec2(((quarter + 1) & 2) == 0 ? near_cos : -near_cos,
              (quarter & 2) == 0 ? near_sin : -near_sin);
}

SHARED_FN float MaxComponent(vec3 v) {
  return max(v.x, max(v.y, v.z));
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_SHARED_H
