// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Small geometric helpers of the path tracer.
#ifndef STILLRAY_RENDER_GEOMETRY_SHARED_H
#define STILLRAY_RENDER_GEOMETRY_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// An orthonormal frame whose z axis is a given normal.
struct LocalFrame {
  vec3 x;
  vec3 y;
  vec3 z;
};

SHARED_FN vec3 ToLocal(SHARED_IN(LocalFrame) frame, vec3 w) {
  return vec3(dot(w, frame.x), dot(w, frame.y), dot(w, frame.z));
}
SHARED_FN vec3 ToWorld(SHARED_IN(LocalFrame) frame, vec3 w) {
  return frame.x * w.x + frame.y * w.y + frame.z * w.z;
}

// Duff et al. (2017), "Building an Orthonormal Basis, Revisited".
SHARED_FN LocalFrame MakeLocalFrame(vec3 n) {
  float side = floatBitsToInt(n.z) < 0 ? -1.0f : 1.0f;
  float a = -1.0f / (side + n.z);
  float b = n.x * n.y * a;
  LocalFrame frame;
  frame.x = vec3(1.0f + side * n.x * n.x * a, side * b, -side * n.x);
  frame.y = vec3(b, side + n.y * n.y * a, -n.y);
  frame.z = n;
  return frame;
}

// v / |v|, or `fallback` if that is undefined.
SHARED_FN vec3 SafeNormalize(vec3 v, vec3 fallback) {
  float length2 = dot(v, v);
  return length2 > 1e-30f && length2 < 1e30f ? v * (1.0f / sqrt(length2)) : fallback;
}

SHARED_FN float OffsetCoordinate(float position, float normal) {
  const float kOrigin = 1.0f / 32.0f;
  const float kFloatScale = 1.0f / 65536.0f;
  const float kIntScale = 256.0f;
  if (abs(position) < kOrigin) {
    return position + kFloatScale * normal;
  }
  int steps = int(kIntScale * normal);
  return intBitsToFloat(floatBitsToInt(position) + (position < 0.0f ? -steps : steps));
}

// Offsets p to the side of n, far enough that a ray from the offset point does not hit the surface
// again: some units in the last place, or a small distance near the origin. Waechter and Binder
// (2019), "A Fast and Robust Method for Avoiding Self-Intersection".
SHARED_FN vec3 OffsetPoint(vec3 p, vec3 n) {
  return vec3(OffsetCoordinate(p.x, n.x), OffsetCoordinate(p.y, n.y), OffsetCoordinate(p.z, n.z));
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_GEOMETRY_SHARED_H
