// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// For frames processed backward: writes the fetched history of this frame's pixels, corrected and
// shortened by limit_history and by the confidence, which is the history of the later frames. In
// the unit of the input, independent of the exposure.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/limit_history.glsl"

layout(set = 1, binding = 0) uniform texture2DArray colour;
layout(set = 1, binding = 1) uniform texture2DArray moments;
layout(set = 1, binding = 2) uniform texture2DArray limits;  // ratio, relative bias
// luminance, red, blue, length; mean, variance, sum of squared weights
layout(set = 1, binding = 3, rgba32f) writeonly uniform image2DArray light_out;
layout(set = 1, binding = 4, rgba32f) writeonly uniform image2DArray moments_out;

layout(push_constant) uniform Push {
  int limited;
};

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  bool is_certain = Confidence(p) >= 1.0f;
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec4 m = texelFetch(moments, at, 0);
    m.z = max(m.z, 0.0f);
    vec4 of_history = limited != 0 ? texelFetch(limits, at, 0) : vec4(1.0f, 0.0f, 0.0f, 0.0f);
    float most = MostLength(m, of_history);
    bool shortened = most < m.z || (!is_certain && most > 0.0f);
    float weights2 = shortened ? max(m.w, 1.0f / most) : m.w;
    float unit = of_history.x / exposure[s];
    imageStore(light_out, at, vec4(texelFetch(colour, at, 0).xyz * unit, min(m.z, most)));
    imageStore(moments_out, at, vec4(m.x * unit, VarianceOf(m.y * unit), weights2, 0.0f));
  }
}
