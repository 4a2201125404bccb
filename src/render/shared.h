// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What the renderer's headers of formulas need beside core/shared.h to compile both as C++ and as
// GLSL. GLSL has no namespaces; in C++ the formulas live in stillray::render.
#ifndef STILLRAY_RENDER_SHARED_H
#define STILLRAY_RENDER_SHARED_H

#ifdef __cplusplus
#include <glm/trigonometric.hpp>

#include "core/shared.h"

#define STILLRAY_RENDER_BEGIN namespace stillray::render {
#define STILLRAY_RENDER_END }

namespace stillray::render {
using glm::cos;
using glm::cross;
using glm::floor;
using glm::fract;
using glm::length;
using glm::mix;
using glm::normalize;
using glm::sin;
using glm::uvec4;
}  // namespace stillray::render
#else
#define STILLRAY_RENDER_BEGIN
#define STILLRAY_RENDER_END
#endif

STILLRAY_RENDER_BEGIN

const float kPi = 3.14159265f;
const float kInvPi = 0.31830989f;

SHARED_FN float MaxComponent(vec3 v) {
  return max(v.x, max(v.y, v.z));
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_SHARED_H
