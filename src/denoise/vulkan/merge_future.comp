// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// merge_future: see stages/merge_future.h. The history is unchanged; the merged input of the
// wavelet is written to other images.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/merge_future_shared.h"

layout(set = 1, binding = 0) uniform texture2DArray colour;
layout(set = 1, binding = 1) uniform texture2DArray moments;
layout(set = 1, binding = 2) uniform texture2DArray future_light;  // from shorten_history
layout(set = 1, binding = 3) uniform texture2DArray future_moments;
layout(set = 1, binding = 4, LIGHT_FORMAT) writeonly uniform image2DArray colour_out;
layout(set = 1, binding = 5, LIGHT_FORMAT) writeonly uniform image2DArray moments_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    vec3 past = texelFetch(colour, at, 0).xyz;
    vec4 m = texelFetch(moments, at, 0);
    vec4 light = texelFetch(future_light, at, 0);
    vec4 later = texelFetch(future_moments, at, 0);
    vec3 c = ClampLight(light.xyz * exposure[s]);
    float mean = clamp(later.x * exposure[s], -kMostLight, kMostLight);
    float variance = later.y * exposure[s] * exposure[s];
    float share = FutureShare(m.z, m.w, light.w, later.z);
    float d = mean - m.x;
    float mixed = MixedVariance(VarianceOf(m.y), d, variance, share);
    imageStore(colour_out, at, Stored(vec4(past + share * (c - past), 0.0f)));
    imageStore(moments_out, at,
               Stored(vec4(m.x + share * d, PackDeviation(mixed, true),
                           min(m.z + light.w, kMostLength), MergedWeights2(m.w, later.z, share))));
  }
}
