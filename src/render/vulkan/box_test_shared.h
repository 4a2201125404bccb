// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Ray/box intersection with the four boxes of a BvhNode. Conservative as in Ize (2013), "Robust BVH
// Ray Traversal": rounding never misses a box that the exact ray intersects.
#ifndef STILLRAY_RENDER_VULKAN_BOX_TEST_SHARED_H
#define STILLRAY_RENDER_VULKAN_BOX_TEST_SHARED_H

#ifdef __cplusplus
#include <glm/vector_relational.hpp>

#include "render/vulkan/scene_shared.h"

#define SHARED_PRECISE

namespace stillray::render {
using bvec3 = glm::bvec3;
using bvec4 = glm::bvec4;
using uvec3 = glm::uvec3;
using glm::equal;
using glm::floatBitsToUint;
using glm::lessThan;
using glm::lessThanEqual;
using glm::uintBitsToFloat;
}  // namespace stillray::render
#else
#define SHARED_PRECISE precise
#endif

STILLRAY_RENDER_BEGIN

// The grid of a node as distances along a ray. The ray intersects plane q of an axis, 0 to 255,
// between the distances q * step + enter and q * step + leave.
struct GridOnRay {
  vec3 step;
  vec3 enter;
  vec3 leave;
};

// The error of q * step + offset, in units of 2^-24 of |255 step| + |offset|: 5 for a reciprocal of
// up to 2.5 units in the last place (the limit of Vulkan); 2 for the offset, a difference and a
// product; 1 for the margin's own sum; 1 for the last sum, and 1 for its product where it is not
// fused, each of one of the two terms only: 9 in all. The bound is relative to the terms, since
// their sum may be much smaller. The remaining 3 cover the rounding of the margin.
const float kGridError = 12.0f * 5.9604645e-8f;
// Where devices flush products to zero, errors are up to 258 times the smallest normal number.
const float kGridUnderflow = 1e-35f;

// \param inverse  reciprocals of the direction's components; finite, so that products with a zero
//     difference are 0
SHARED_FN GridOnRay PlaceGrid(SHARED_IN(vec3) origin, SHARED_IN(vec3) scale,
                              SHARED_IN(vec3) ray_origin, SHARED_IN(vec3) inverse) {
  GridOnRay grid;
  grid.step = scale * inverse;  // exact: powers of two
  // A product of a difference: the difference of two products could cancel.
  SHARED_PRECISE vec3 offset = (origin - ray_origin) * inverse;
  vec3 margin = (abs(grid.step) * 255.0f + abs(offset)) * kGridError + kGridUnderflow;
  grid.enter = offset - margin;
  grid.leave = offset + margin;
  return grid;
}

SHARED_FN vec4 BytesOf(uint packed) {
  return vec4(uvec4(packed, packed >> 8, packed >> 16, packed >> 24) & 255u);
}

// Hit distances have rounding errors that differ from those of box distances: the ray is extended
// by this factor for box tests.
const float kEndScale = 1.0f + 32.0f * 5.9604645e-8f;

// Larger than the bit pattern of any distance.
const uint kMissed = 0xffffffffu;

// Lower bounds of the distances at which the ray enters the boxes of the node's children, as float
// bits with the child's index in the two lowest bits; kMissed: no intersection up to `end`. end >=
// 0.
SHARED_FN uvec4 EnterChildren(SHARED_IN(BvhNode) node, SHARED_IN(vec3) ray_origin,
                              SHARED_IN(vec3) inverse, float end) {
  vec3 scale = uintBitsToFloat(
      (uvec3(node.exponents, node.exponents >> 8, node.exponents >> 16) & 255u) << 23u);
  GridOnRay grid = PlaceGrid(node.origin, scale, ray_origin, inverse);
  uvec3 low = uvec3(node.low_x, node.low_y, node.low_z);
  uvec3 high = uvec3(node.high_x, node.high_y, node.high_z);
  bvec3 backwards = lessThan(inverse, vec3(0.0f));
  uvec3 first = mix(low, high, backwards);
  uvec3 last = mix(high, low, backwards);
  vec4 enter_x = BytesOf(first.x) * grid.step.x + grid.enter.x;
  vec4 enter_y = BytesOf(first.y) * grid.step.y + grid.enter.y;
  vec4 enter_z = BytesOf(first.z) * grid.step.z + grid.enter.z;
  vec4 leave_x = BytesOf(last.x) * grid.step.x + grid.leave.x;
  vec4 leave_y = BytesOf(last.y) * grid.step.y + grid.leave.y;
  vec4 leave_z = BytesOf(last.z) * grid.step.z + grid.leave.z;
  vec4 enter = max(max(enter_x, enter_y), max(enter_z, vec4(0.0f)));
  vec4 leave = min(min(leave_x, leave_y), min(leave_z, vec4(end * kEndScale)));
  // abs maps -0, the result for a ray that starts inside, to 0.
  uvec4 bits = (floatBitsToUint(abs(enter)) & ~3u) | uvec4(0u, 1u, 2u, 3u);
  bits = mix(uvec4(kMissed), bits, lessThanEqual(enter, leave));
  return mix(bits, uvec4(kMissed), equal(node.children, uvec4(0u)));
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_VULKAN_BOX_TEST_SHARED_H
