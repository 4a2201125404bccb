// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// The rest of a frame after a layer was denoised: writes its emission plus the layer's image, and
// its motion as in FollowImages of picture_motion.h. The emission's alpha is the history length of
// the virtual image (TakeLengths), 0 for pixels without one.
#include "denoise/vulkan/layer_images.glsl"
#include "denoise/picture_motion_shared.h"

layout(set = 0, binding = 0) uniform texture2D surface_depth;
layout(set = 0, binding = 1) uniform texture2D surface_motion;
layout(set = 0, binding = 2) uniform utexture2D surface_id;
layout(set = 0, binding = 3) uniform texture2D emission;
layout(set = 0, binding = 4) uniform texture2D selected_motion;
layout(set = 0, binding = 5) uniform texture2D selected_albedo;  // see select_guides.comp
layout(set = 0, binding = 6) uniform texture2D picture;          // alpha: history length
layout(set = 0, binding = 7, rg32f) writeonly uniform image2D motion_out;
layout(set = 0, binding = 8, rgba32f) writeonly uniform image2D emission_out;

layout(push_constant) uniform Push {
  int has_id;
  int has_emission;
  int has_length;  // 1: the emission's alpha has the length of another layer
  int width;
  int height;
};

uint IdAt(ivec2 p) {
  return has_id != 0 ? texelFetch(surface_id, p, 0).x : 0u;
}

bool ShowsLittleElseAt(ivec2 p) {
  return texelFetch(selected_albedo, p, 0).w > 0.0f;
}

// Whether a pixel and its neighbours show virtual images on one surface.
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

vec2 MotionAt(ivec2 p) {
  return texelFetch(selected_motion, p, 0).xy;
}

// See NearestImageMotion of picture_motion.cpp.
vec2 NearestImageMotion(ivec2 p, ivec2 size) {
  vec2 own = MotionAt(p);
  float depth = texelFetch(selected_albedo, p, 0).w;
  float nearest = depth;
  vec2 result = own;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = p + ivec2(dx, dy);
      if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, size))) {
        continue;
      }
      ivec2 across = clamp(p - ivec2(dx, dy), ivec2(0), size - 1);
      float neighbour = texelFetch(selected_albedo, q, 0).w;
      float opposite = texelFetch(selected_albedo, across, 0).w;
      vec2 candidate = MotionAt(q);
      if (neighbour < nearest && StandsInFrontOfImage(depth, neighbour, opposite) &&
          HasImageMotion(candidate.x, float(size.x)) && MovesNearly(own, candidate)) {
        nearest = neighbour;
        result = candidate;
      }
    }
  }
  return result;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  ivec2 size = ivec2(width, height);
  if (p.x >= size.x || p.y >= size.y) {
    return;
  }
  bool follows = HasImageMotion(MotionAt(p).x, float(size.x)) && IsWithin(p, size);
  vec2 motion = follows ? NearestImageMotion(p, size) : texelFetch(surface_motion, p, 0).xy;
  imageStore(motion_out, p, vec4(motion, 0.0f, 0.0f));
  vec4 own = texelFetch(picture, p, 0);
  vec4 other = has_emission != 0 ? texelFetch(emission, p, 0) : vec4(0.0f);
  float length = ShowsLittleElseAt(p) ? own.w : (has_length != 0 ? other.w : 0.0f);
  imageStore(emission_out, p, vec4(own.xyz + other.xyz, length));
}
