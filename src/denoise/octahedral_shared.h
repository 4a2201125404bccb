// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Unit vectors as two numbers, over the whole sphere.
#ifndef STILLRAY_DENOISE_OCTAHEDRAL_SHARED_H
#define STILLRAY_DENOISE_OCTAHEDRAL_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// Projects a direction onto the octahedron |x| + |y| + |z| = 1, whose lower half is folded outwards
// (Meyer et al. 2010, "On Floating-Point Normal Vectors"). Both coordinates are in -1..1.
SHARED_FN vec2 OctahedralEncode(vec3 n) {
  float scale = 1.0f / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-20f);
  float x = n.x * scale;
  float y = n.y * scale;
  float folded_x = (1.0f - abs(y)) * (x >= 0.0f ? 1.0f : -1.0f);
  float folded_y = (1.0f - abs(x)) * (y >= 0.0f ? 1.0f : -1.0f);
  return n.z >= 0.0f ? vec2(x, y) : vec2(folded_x, folded_y);
}

// The inverse of OctahedralEncode; the result has unit length.
SHARED_FN vec3 OctahedralDecode(vec2 e) {
  float z = 1.0f - abs(e.x) - abs(e.y);
  float fold = max(-z, 0.0f);
  float x = e.x + (e.x >= 0.0f ? -fold : fold);
  float y = e.y + (e.y >= 0.0f ? -fold : fold);
  float scale = 1.0f / sqrt(x * x + y * y + z * z);
  return vec3(x * scale, y * scale, z * scale);
}

SHARED_END

#endif
