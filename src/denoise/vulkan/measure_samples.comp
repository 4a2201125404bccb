// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// keep_samples, before its wavelet levels: see stages/keep_samples.h. Writes the squared difference
// of filtered signal and samples, and the variance of the samples.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/sample_squares.glsl"
#include "denoise/stages/keep_samples_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform texture2DArray noisy;
layout(set = 1, binding = 2) uniform texture2DArray within_image;
layout(set = 1, binding = 3) uniform texture2DArray moments;
layout(set = 1, binding = 4) uniform texture2DArray light;
layout(set = 1, binding = 5, LIGHT_FORMAT) writeonly uniform image2DArray measured_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  float inverse_depth = uintBitsToFloat(texelFetch(surface_image, p, 0).x);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec4 x = texelFetch(noisy, at, 0);
    vec4 measured = vec4(0.0f, 0.0f, 0.0f, PackDeviation(0.0f, false));
    if ((keep_samples.kept_signals >> s & 1) != 0 && KeepsSamples(inverse_depth, x.w)) {
      float d = x.x - texelFetch(light, at, 0).x;
      float within = VarianceOf(texelFetch(within_image, at, 0).x);
      float variance = VarianceOf(texelFetch(moments, at, 0).y);
      measured = SampleSquares(d * d, SampleNoise(within, variance, x.w));
    }
    imageStore(measured_out, at, Stored(measured));
  }
}
