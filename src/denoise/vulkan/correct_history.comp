// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// limit_history, CorrectHistory: see stages/limit_history.h. One invocation per block.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"

layout(set = 1, binding = 0) uniform texture2DArray averaged;
layout(set = 1, binding = 1) uniform texture2DArray compressed;
layout(set = 1, binding = 2) uniform texture2DArray wide;
layout(set = 1, binding = 3, SCALAR_FORMAT) writeonly uniform image2DArray ratio_out;
layout(set = 1, binding = 4, LIGHT_FORMAT) writeonly uniform image2DArray compared_out;

// The compressed history of a block; `here` for blocks without history or outside the image.
float HistoryAt(ivec2 block, int s, float here) {
  if (any(lessThan(block, ivec2(0))) || any(greaterThanEqual(block, CoarseSize()))) {
    return here;
  }
  vec4 c = texelFetch(compressed, ivec3(block, s), 0);
  return IsValid(c.w) ? c.y : here;
}

// BlockSlope along both axes.
vec2 SlopeAt(ivec2 block, int s, float here) {
  return vec2(BlockSlope(HistoryAt(block - ivec2(1, 0), s, here), here,
                         HistoryAt(block + ivec2(1, 0), s, here)),
              BlockSlope(HistoryAt(block - ivec2(0, 1), s, here), here,
                         HistoryAt(block + ivec2(0, 1), s, here)));
}

void main() {
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(block, CoarseSize()))) {
    return;
  }
  vec2 jitter = vec2(limit_history.jitter_x, limit_history.jitter_y);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(block, s);
    vec4 light = texelFetch(averaged, at, 0);
    vec4 c = texelFetch(compressed, at, 0);
    float ratio = 1.0f;
    if (limit_history.correct_history != 0 && IsValid(c.w)) {
      float of_wide = 1.0f;
      if (s < limit_history.wide_signals) {
        vec4 change = texelFetch(wide, at, 0);
        of_wide = WideRatio(change.x / kChangeScale, change.y / (kChangeScale * kChangeScale),
                            ChangeVariance(VarianceOf(light.w), light.y), VarianceOf(change.w));
      }
      ratio = CorrectedRatio(light.x, light.y, VarianceOf(light.w), of_wide, MovingLightOf(s));
    }
    float difference = ratio != 1.0f ? c.x + (c.y - ScaledCompressed(c.y, ratio)) : c.x;
    float deviation = c.w;
    if (any(notEqual(jitter, vec2(0.0f))) && IsValid(c.w)) {
      vec2 slope = SlopeAt(block, s, c.y);
      difference -= JitterShift(slope.x, slope.y, jitter.x, jitter.y);
      deviation = PackDeviation(VarianceOf(c.w) + JitterNoise(slope.x, slope.y), true);
    }
    imageStore(ratio_out, at, vec4(ratio));
    imageStore(compared_out, at, Stored(vec4(difference, 0.0f, c.z, deviation)));
  }
}
