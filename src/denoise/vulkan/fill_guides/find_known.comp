// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides, FindKnown: counts the known pixels, tests whether any of them has motion, and
// downsamples their motion to the first level. One invocation per cell.
#define CELLS_BINDING 0
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/held_guides.glsl"
#include "denoise/vulkan/fill_guides/pyramid.glsl"
#include "denoise/vulkan/reduce.glsl"

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  Level level = FirstLevel();
  Mean mean = NoMean();
  bool moves = false;
  for (int i = 0; i < kPyramidFactor * kPyramidFactor; ++i) {
    ivec2 q = p * kPyramidFactor + ivec2(i % kPyramidFactor, i / kPyramidFactor);
    if (Inside(q) && IsKnown(q)) {
      vec2 motion = texelFetch(motion_image, q, 0).xy;
      moves = moves || IsMoving(motion.x) || IsMoving(motion.y);
      Add(mean, i % kPyramidFactor, vec3(motion, 0.0f));
    }
  }
  if (Covers(level, p)) {
    StoreCell(level, kMotionLayer, p, ValueOf(mean), mean.count > 0 ? kNew : 0u);
  }
  vec4 sum = SumOfGroup(vec4(float(mean.count), moves ? 1.0f : 0.0f, 0.0f, 0.0f));
  if (gl_LocalInvocationIndex == 0u) {
    atomicAdd(known_pixels, uint(sum.x));
    if (sum.y > 0.0f) {
      atomicOr(guides_move, 1u);
    }
  }
}
