// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// follow_light, first pass: see stages/follow_light.h. One invocation per block: writes its
// radiance, and the change since the last frame.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/new_light.glsl"
#include "denoise/stages/follow_light_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform texture2DArray light;
layout(set = 1, binding = 2) uniform texture2DArray moments;
layout(set = 1, binding = 3) uniform texture2D before;
layout(set = 1, binding = 4, r32f) writeonly uniform image2D light_out;
layout(set = 1, binding = 5, rgba32f) writeonly uniform image2D changes_out;  // change, known

layout(push_constant) uniform Push {
  int has_before;
};

float UnfilteredLight(vec3 value) {
  float l = Luminance709(value.x, value.y, value.z);
  return IsFinite(l) ? max(l, 0.0f) : 0.0f;
}

float InverseDepthAt(ivec2 p) {
  return uintBitsToFloat(texelFetch(surface_image, p, 0).x);
}

// Whether another surface is within kFollowClear pixels along an axis.
bool IsNearSurface(ivec2 p, float here) {
  for (int k = 1; k <= kFollowClear; ++k) {
    ivec2 dx = ivec2(k, 0);
    ivec2 dy = ivec2(0, k);
    bool row = p.x >= k && p.x + k < width &&
               IsBesideSurface(here, InverseDepthAt(p - dx), InverseDepthAt(p + dx));
    bool column = p.y >= k && p.y + k < height &&
                  IsBesideSurface(here, InverseDepthAt(p - dy), InverseDepthAt(p + dy));
    if (row || column) {
      return true;
    }
  }
  return false;
}

void main() {
  ivec2 block = ivec2(gl_GlobalInvocationID.xy);
  ivec2 blocks = ivec2(FollowSize(width), FollowSize(height));
  if (any(greaterThanEqual(block, blocks))) {
    return;
  }
  ivec2 p = ivec2(FollowPixel(block.x, width), FollowPixel(block.y, height));
  float reflected = 0.0f;
  float albedo = 0.0f;
  float rest = 0.0f;
  for (int s = 0; s < SignalCount(); ++s) {
    float l = texelFetch(light, ivec3(p, s), 0).x / exposure[s];
    l *= demodulate.firefly == 2 ? ExpandScale(l) : 1.0f;
    vec3 sum = AlbedosOf(s) != 0 ? AlbedoSum(s, p) : vec3(1.0f);
    float divisor = AlbedosOf(s) != 0 ? max(Luminance709(sum.x, sum.y, sum.z), kAlbedoFloor) : 1.0f;
    divisor = IsFinite(divisor) ? divisor : 1.0f;
    if (by_channel != 0) {
      int c = ChannelOf(s);
      vec3 part = vec3(0.0f);
      part[c] = IsFinite(sum[c]) ? max(sum[c], kAlbedoFloor) : 1.0f;
      divisor = Luminance709(part.x, part.y, part.z);
    }
    bool follows = s < antialias.follow_light;
    reflected += follows ? divisor * max(l, 0.0f) : 0.0f;
    albedo += follows ? divisor : 0.0f;
    rest += follows ? 0.0f : divisor * max(l, 0.0f);
  }
  rest += (has_emission != 0 ? UnfilteredLight(texelFetch(emission_image, p, 0).xyz) : 0.0f) +
          (has_background != 0 ? UnfilteredLight(texelFetch(background_image, p, 0).xyz) : 0.0f);
  float own = albedo > 0.0f ? reflected / albedo : 0.0f;
  vec2 place = vec2(p) + texelFetch(motion_image, p, 0).xy;
  bool inside = place.x > -0.5f && place.y > -0.5f && place.x < float(width) - 0.5f &&
                place.y < float(height) - 0.5f && !IsNaN(place.x) && !IsNaN(place.y);
  float here = InverseDepthAt(p);
  bool known = has_before != 0 && inside && here > 0.0f &&
               texelFetch(moments, ivec3(p, 0), 0).z > GivenSamples(p) && !IsNearSurface(p, here);
  float change = 0.0f;
  if (known) {
    ivec2 at = ivec2(FollowNearest(place.x, blocks.x), FollowNearest(place.y, blocks.y));
    change = LogChange(albedo * own + rest, albedo * texelFetch(before, at, 0).x + rest);
  }
  imageStore(light_out, block, vec4(own));
  imageStore(changes_out, block, vec4(change, known ? 1.0f : 0.0f, 0.0f, 0.0f));
}
