// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// accumulate: see stages/accumulate.h. Applies the result of limit_history.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"
#include "denoise/stages/accumulate_shared.h"

layout(set = 1, binding = 0) uniform texture2DArray noisy;
layout(set = 1, binding = 1) uniform texture2DArray within_image;
layout(set = 1, binding = 2) uniform texture2DArray colour;
layout(set = 1, binding = 3) uniform texture2DArray behind;
layout(set = 1, binding = 4) uniform texture2DArray moments;
layout(set = 1, binding = 5) uniform texture2DArray compressed;
layout(set = 1, binding = 6) uniform texture2DArray limits;  // ratio, relative bias
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2DArray colour_out;
layout(set = 1, binding = 8, LIGHT_FORMAT) writeonly uniform image2DArray behind_out;
layout(set = 1, binding = 9, LIGHT_FORMAT) writeonly uniform image2DArray moments_out;
layout(set = 1, binding = 10, FRACTION_FORMAT) writeonly uniform image2DArray compressed_out;

layout(push_constant) uniform Push {
  int limited;
};

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  float confidence = has_history != 0 ? Confidence(p) : 1.0f;
  float least = ConfidentAlpha(accumulate.alpha_min, confidence);
  float least_of_moments = ConfidentAlpha(accumulate.alpha_moments, confidence);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec4 light = texelFetch(noisy, at, 0);
    vec4 m = has_history != 0 ? texelFetch(moments, at, 0) : vec4(0.0f);
    vec3 c = has_history != 0 ? texelFetch(colour, at, 0).xyz : vec3(0.0f);
    m.z = max(m.z, 0.0f);
    m.y = VarianceOf(m.y);
    float n = light.w;
    float history_length = m.z;
    float ratio = 1.0f;
    if (limited != 0) {
      vec4 of_history = texelFetch(limits, at, 0);
      history_length = MostLength(m, of_history);
      ratio = of_history.x;
      c *= ratio;
      m.x *= ratio;
      m.y *= ratio * ratio;
    }
    if (accumulate.max_history > 0) {
      history_length = min(history_length, max(float(accumulate.max_history) - n, 0.0f));
    }
    float alpha = NewFrameWeight(history_length, n, least, accumulate.history_weight_constant != 0);
    float alpha_of_moments = NewFrameWeight(history_length, n, least_of_moments,
                                            accumulate.history_weight_constant != 0);
    float d = light.x - m.x;
    float within = second_moments != 0 ? VarianceOf(texelFetch(within_image, at, 0).x) : 0.0f;
    float variance = MixedVariance(m.y, d, within, alpha_of_moments);
    imageStore(colour_out, at, Stored(vec4(c + alpha * (light.xyz - c), 0.0f)));
    imageStore(moments_out, at,
               Stored(vec4(m.x + alpha_of_moments * d, PackDeviation(variance, true),
                           min(n > 0.0f ? history_length + n : m.z, kMostLength),
                           MixedWeights2(m.w, n, alpha))));
    if (with_behind != 0) {
      vec3 b = has_history != 0 ? ratio * texelFetch(behind, at, 0).xyz : vec3(0.0f);
      imageStore(behind_out, at, Stored(vec4(b + alpha * (light.xyz - b), 0.0f)));
    }
    if (with_compressed != 0) {
      float old = has_history != 0 ? texelFetch(compressed, at, 0).x : 0.0f;
      old = ratio != 1.0f ? ScaledCompressed(old, ratio) : old;
      float now = CompressLuminance(light.x, compressed_scale[s] * exposure[s]);
      imageStore(compressed_out, at, vec4(old + alpha * (now - old)));
    }
  }
}
