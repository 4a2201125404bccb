// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// remodulate: see stages/remodulate.h. Also inverts firefly compression.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/new_light.glsl"
#include "denoise/vulkan/filtered_light.glsl"

layout(set = 1, binding = 0) uniform texture2DArray light;
layout(set = 1, binding = 1, LIGHT_FORMAT) writeonly uniform image2D picture_out;

layout(push_constant) uniform Push {
  int counts;  // invalid pixels of emission and background are counted
};

vec3 Radiance(int s, ivec2 p) {
  vec3 rgb = FilteredLight(texelFetch(light, ivec3(p, s), 0).xyz, s);
  if (AlbedosOf(s) != 0) {
    vec3 factor = AlbedoSum(s, p);
    for (int c = 0; c < 3; ++c) {
      rgb[c] = Remodulate(rgb[c], IsFinite(factor[c]) ? factor[c] : 1.0f);
    }
  }
  return rgb;
}

vec3 AddUnfiltered(vec3 sum, vec3 other) {
  if (!IsFinite(other)) {
    if (counts != 0) {
      atomicAdd(non_finite, 1u);
    }
    return sum;
  }
  return sum + other;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  vec3 sum = vec3(0.0f);
  for (int s = 0; s < SignalCount(); ++s) {
    sum += Radiance(s, p);
  }
  if (has_emission != 0) {
    sum = AddUnfiltered(sum, texelFetch(emission_image, p, 0).xyz);
  }
  if (has_background != 0) {
    sum = AddUnfiltered(sum, texelFetch(background_image, p, 0).xyz);
  }
  // See kMostPicture.
  const float most = min(kMostLight, 1e37f);
  vec3 picture = clamp(sum * picture_exposure, vec3(-most), vec3(most));
  imageStore(picture_out, p, Stored(vec4(picture, 1.0f)));
}
