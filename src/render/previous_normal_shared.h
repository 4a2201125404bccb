// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Guides::previous_normal of surfaces that rotate with their instance or deform.
#ifndef STILLRAY_RENDER_PREVIOUS_NORMAL_SHARED_H
#define STILLRAY_RENDER_PREVIOUS_NORMAL_SHARED_H

#ifdef __cplusplus
#include "render/geometry_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Rows of a matrix without its translation.
struct LinearRows {
  vec3 x;
  vec3 y;
  vec3 z;
};

// The previous-frame normal of n; zero, meaning unchanged, if the linear part of the transform is
// unchanged. Normals are transformed by the inverse transpose: the transpose of `now` transforms
// back to object space, up to a positive factor, and the cofactors of `before` are its inverse
// transpose times its determinant.
SHARED_FN vec3 PreviousNormal(SHARED_IN(LinearRows) now, SHARED_IN(LinearRows) before, vec3 n) {
  if (now.x == before.x && now.y == before.y && now.z == before.z) {
    return vec3(0.0f);
  }
  vec3 local = SafeNormalize(now.x * n.x + now.y * n.y + now.z * n.z, vec3(0.0f));
  vec3 cofactors = cross(before.y, before.z);
  float side = dot(before.x, cofactors) < 0.0f ? -1.0f : 1.0f;
  return SafeNormalize(side * vec3(dot(cofactors, local), dot(cross(before.z, before.x), local),
                                   dot(cross(before.x, before.y), local)),
                       vec3(0.0f));
}

// Tangent frame of a hit: the interpolated normal, unit length, and an edge of the triangle.
struct SurfaceFrame {
  vec3 normal;
  vec3 edge;
};

// The previous-frame normal of n on a deforming surface: n is constant relative to the
// SurfaceFrame. Without a normal map the result is the interpolated normal of the previous frame.
SHARED_FN vec3 DeformedNormal(SHARED_IN(SurfaceFrame) now, SHARED_IN(SurfaceFrame) before, vec3 n) {
  if (now.normal == before.normal && now.edge == before.edge) {
    return n;
  }
  vec3 x = SafeNormalize(now.edge - now.normal * dot(now.edge, now.normal), vec3(0.0f));
  vec3 x_before =
      SafeNormalize(before.edge - before.normal * dot(before.edge, before.normal), vec3(0.0f));
  vec3 y = cross(now.normal, x);
  vec3 y_before = cross(before.normal, x_before);
  return SafeNormalize(
      x_before * dot(n, x) + y_before * dot(n, y) + before.normal * dot(n, now.normal), n);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_PREVIOUS_NORMAL_SHARED_H
