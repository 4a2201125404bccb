// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// The frame without the light of a layer that is denoised: its emission with the layer's picture,
// and its motion as FollowImages of picture_motion.h makes it.
#include "denoise/vulkan/layer_images.glsl"
#include "denoise/picture_motion_shared.h"

layout(set = 0, binding = 0) uniform texture2D surface_depth;
layout(set = 0, binding = 1) uniform texture2D surface_motion;
layout(set = 0, binding = 2) uniform utexture2D surface_id;
layout(set = 0, binding = 3) uniform texture2D emission;
layout(set = 0, binding = 4) uniform texture2D selected_motion;
layout(set = 0, binding = 5) uniform texture2D selected_albedo;  // see select_guides.comp
layout(set = 0, binding = 6) uniform texture2D picture;
layout(set = 0, binding = 7, rg32f) writeonly uniform image2D motion_out;
layout(set = 0, binding = 8, rgba32f) writeonly uniform image2D emission_out;

layout(push_constant) uniform Push {
  int has_id;
  int has_emission;
  int width;
  int height;
};

uint IdAt(ivec2 p) {
  return has_id != 0 ? texelFetch(surface_id, p, 0).x : 0u;
}

bool ShowsLittleElseAt(ivec2 p) {
  return texelFetch(selected_albedo, p, 0).w > 0.0f;
}

// Whether a pixel and those around it show images on one surface.
bool IsWithin(ivec2 p, ivec2 size) {
  if (!ShowsLittleElseAt(p)) {
    return false;
  }
  float depth = texelFetch(surface_depth, p, 0).x;
  uint id = IdAt(p);
  ivec2 first = max(p - kSilhouette, ivec2(0));
  ivec2 last = min(p + kSilhouette, size - 1);
  for (int v = first.y; v <= last.y; ++v) {
    for (int u = first.x; u <= last.x; ++u) {
      ivec2 q = ivec2(u, v);
      if (!ShowsLittleElseAt(q) || IdAt(q) != id ||
          IsOtherSurface(depth, texelFetch(surface_depth, q, 0).x)) {
        return false;
      }
    }
  }
  return true;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = ivec2(width, height);
  if (p.x >= size.x || p.y >= size.y) {
    return;
  }
  bool follows = IsWithin(p, size);
  vec2 motion = (follows ? texelFetch(selected_motion, p, 0) : texelFetch(surface_motion, p, 0)).xy;
  imageStore(motion_out, p, vec4(motion, 0.0f, 0.0f));
  vec3 sum = texelFetch(picture, p, 0).xyz;
  if (has_emission != 0) {
    sum += texelFetch(emission, p, 0).xyz;
  }
  imageStore(emission_out, p, vec4(sum, 0.0f));
}
