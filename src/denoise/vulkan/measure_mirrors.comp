// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// keep_mirrors, before its wavelet levels: see stages/keep_mirrors.h. Writes the squared difference
// of filtered signal and sample, and the variance of the sample.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/sample_squares.glsl"
#include "denoise/stages/keep_mirrors_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform texture2DArray noisy;
layout(set = 1, binding = 2) uniform texture2DArray light;
layout(set = 1, binding = 3, LIGHT_FORMAT) writeonly uniform image2DArray measured_out;

bool IsMirrorAt(ivec2 p, int s) {
  return Inside(p) && IsMirror(uintBitsToFloat(texelFetch(surface_image, p, 0).x),
                               texelFetch(noisy, ivec3(p, s), 0).w,
                               texelFetch(roughness_image, p, 0).x, keep_mirrors.mirror_roughness);
}

float NoiseScale(ivec2 p) {
  vec2 motion = has_history != 0 ? abs(texelFetch(motion_image, p, 0).xy) : vec2(1.0f);
  bool still = motion.x < kStillMotion && motion.y < kStillMotion;
  return still ? kStillNoise * kNearestNoise : kNearestNoise;
}

float NoiseAt(ivec2 p, int s) {
  float own = texelFetch(noisy, ivec3(p, s), 0).x;
  float first = kNoNeighbour;
  float second = kNoNeighbour;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = p + ivec2(dx, dy);
      if ((dx != 0 || dy != 0) && IsMirrorAt(q, s)) {
        float d = own - texelFetch(noisy, ivec3(q, s), 0).x;
        second = min(second, max(first, d * d));
        first = min(first, d * d);
      }
    }
  }
  return NoiseOfNearest(first, second, NoiseScale(p));
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec4 measured = vec4(0.0f, 0.0f, 0.0f, PackDeviation(0.0f, false));
    if ((keep_mirrors.mirror_signals >> s & 1) != 0 && IsMirrorAt(p, s)) {
      float d = texelFetch(noisy, at, 0).x - texelFetch(light, at, 0).x;
      measured = SampleSquares(d * d, NoiseAt(p, s));
    }
    imageStore(measured_out, at, Stored(measured));
  }
}
