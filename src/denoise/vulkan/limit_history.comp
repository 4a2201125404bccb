// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// limit_history, before its wavelet: see stages/limit_history.h. Compressed present less compressed
// history (the difference, because halves would round it away), variance of single compressed
// samples; deviation of the expected noise.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform texture2DArray noisy;
layout(set = 1, binding = 2) uniform texture2DArray moments;
layout(set = 1, binding = 3) uniform texture2DArray compressed;
layout(set = 1, binding = 4, LIGHT_FORMAT) writeonly uniform image2DArray compared_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  bool surface = uintBitsToFloat(texelFetch(surface_image, p, 0).x) > 0.0f;
  for (int s = 0; s < signals; ++s) {
    ivec3 at = ivec3(p, s);
    vec4 light = texelFetch(noisy, at, 0);
    vec4 m = texelFetch(moments, at, 0);
    vec4 compared = vec4(0.0f, 0.0f, 0.0f, PackDeviation(0.0f, false));
    if (surface && light.w > 0.0f && m.z > 0.0f) {
      float scale = compressed_scale[s] * exposure[s];
      float then = RescaledCompressed(texelFetch(compressed, at, 0).x, s);
      float single = CompressedVariance(then, m.x, VarianceOf(m.y), scale);
      float noise = single * (1.0f / max(light.w, 1.0f) + m.w);
      compared = vec4(CompressLuminance(light.x, scale) - then, 0.0f, single * kSingleScale,
                      PackDeviation(noise, true));
    }
    imageStore(compared_out, at, Stored(compared));
  }
}
