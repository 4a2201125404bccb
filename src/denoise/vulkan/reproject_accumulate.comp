// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// reproject and accumulate in one pass, without limit_history: the fetched history is not stored in
// images. Bit-identical to separate passes.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fetch_history.glsl"

layout(set = 1, binding = 8) uniform texture2DArray noisy;
layout(set = 1, binding = 9) uniform texture2DArray within_image;
layout(set = 1, binding = 10, LIGHT_FORMAT) writeonly uniform image2DArray colour_out;
layout(set = 1, binding = 11, LIGHT_FORMAT) writeonly uniform image2DArray behind_out;
layout(set = 1, binding = 12, LIGHT_FORMAT) writeonly uniform image2DArray moments_out;

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
  Taps taps = FindTaps(p);
  float confidence = Confidence(p);
  vec2 least = LeastWeights(confidence);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    Fetched fetched = Fetch(taps, confidence, s);
    vec4 m = fetched.moments;
    m.z = max(m.z, 0.0f);
    m.y = VarianceOf(m.y);
    NewHistory history = Accumulate(at, fetched.colour, m, fetched.behind, 0.0f, m.z, 1.0f, least);
    imageStore(colour_out, at, history.colour);
    imageStore(moments_out, at, history.moments);
    if (with_behind != 0) {
      imageStore(behind_out, at, history.behind);
    }
  }
}
