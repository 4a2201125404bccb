// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// accumulate: see stages/accumulate.h. Applies the result of limit_history.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"

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

vec4 LoadNoisy(ivec3 at) {
  return texelFetch(noisy, at, 0);
}
float LoadWithin(ivec3 at) {
  return texelFetch(within_image, at, 0).x;
}
#include "denoise/vulkan/new_history.glsl"

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  vec2 least = LeastWeights(has_history != 0 ? Confidence(p) : 1.0f);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec4 m = has_history != 0 ? texelFetch(moments, at, 0) : vec4(0.0f);
    vec3 c = has_history != 0 ? texelFetch(colour, at, 0).xyz : vec3(0.0f);
    m.z = max(m.z, 0.0f);
    m.y = VarianceOf(m.y);
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
    vec3 b = vec3(0.0f);
    if (with_behind != 0 && has_history != 0) {
      b = ratio * texelFetch(behind, at, 0).xyz;
    }
    float old = with_compressed != 0 && has_history != 0 ? texelFetch(compressed, at, 0).x : 0.0f;
    NewHistory history = Accumulate(at, c, m, b, old, history_length, ratio, least);
    imageStore(colour_out, at, history.colour);
    imageStore(moments_out, at, history.moments);
    if (with_behind != 0) {
      imageStore(behind_out, at, history.behind);
    }
    if (with_compressed != 0) {
      imageStore(compressed_out, at, vec4(history.compressed));
    }
  }
}
