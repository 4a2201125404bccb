// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// antialias: see stages/antialias.h. Also writes the picture to the caller's image.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/follow_light_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2DArray moments;
layout(set = 1, binding = 3) uniform texture2D picture;
layout(set = 1, binding = 4) uniform texture2D picture_before;
layout(set = 1, binding = 5) uniform texture2DArray coefficients;
layout(set = 1, binding = 6) uniform texture2D followed_ratio;
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2D picture_out;

vec3 Load(ivec2 p) {
  return texelFetch(picture, ClampToPicture(p), 0).xyz;
}

float InverseDepth(ivec2 p) {
  return uintBitsToFloat(texelFetch(surface_image, p, 0).x);
}

// Motion of the nearest surface of the 3x3 neighbourhood in front of the centre's own; of equal
// ones the first in reading order.
vec2 NearestMotion(ivec2 p) {
  float centre = InverseDepth(p);
  vec2 gradient = UnpackDetail(texelFetch(detail_image, p, 0), centre).gradient;
  float nearest = centre;
  ivec2 place = p;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = ClampToPicture(p + ivec2(dx, dy));
      float i = InverseDepth(q);
      if (i > nearest && StandsInFront(centre, i, gradient, vec2(q - p))) {
        nearest = i;
        place = q;
      }
    }
  }
  return texelFetch(motion_image, place, 0).xy;
}

// The longest history in the 3x3 neighbourhood.
float LongestAround(ivec2 p) {
  float longest = 0.0f;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = ClampToPicture(p + ivec2(dx, dy));
      longest = max(longest, texelFetch(moments, ivec3(q, 0), 0).z);
    }
  }
  return longest;
}

vec3 SamplePrevious(vec2 place) {
  vec2 corner = floor(place);
  vec2 t = place - corner;
  ivec2 first = ivec2(corner) - 1;
  if (t == vec2(0.0f)) {
    return texelFetch(picture_before, ClampToPicture(first + 1), 0).xyz * picture_ratio;
  }
  bool spline = antialias.spline != 0;
  vec4 wx = spline ? CubicSpline(t.x) : CatmullRom(t.x);
  vec4 wy = spline ? CubicSpline(t.y) : CatmullRom(t.y);
  vec3 sum = vec3(0.0f);
  for (int j = 0; j < 4; ++j) {
    vec3 row = vec3(0.0f);
    for (int i = 0; i < 4; ++i) {
      ivec2 q = ClampToPicture(first + ivec2(i, j));
      row += wx[i] * (spline ? texelFetch(coefficients, ivec3(q, 0), 0).xyz
                             : texelFetch(picture_before, q, 0).xyz);
    }
    sum += wy[j] * row;
  }
  return sum * picture_ratio;
}

// The change of the light, interpolated between the pixels of blocks.
float RatioAt(ivec2 p) {
  vec2 place = (vec2(p) - 0.5f * float(kFollowBlock)) / float(kFollowBlock);
  ivec2 corner = ivec2(floor(place));
  vec2 t = place - vec2(corner);
  ivec2 last = ivec2(FollowSize(width), FollowSize(height)) - 1;
  float ratio[4];
  for (int k = 0; k < 4; ++k) {
    ivec2 block = clamp(corner + ivec2(k & 1, k >> 1), ivec2(0), last);
    ratio[k] = texelFetch(followed_ratio, block, 0).x;
  }
  float above = ratio[0] + t.x * (ratio[1] - ratio[0]);
  float below = ratio[2] + t.x * (ratio[3] - ratio[2]);
  return above + t.y * (below - above);
}

vec3 Antialiased(ivec2 p, vec3 now) {
  vec2 motion = NearestMotion(p);
  vec2 place = vec2(p) + motion;
  bool inside = place.x > -0.5f && place.y > -0.5f && place.x < float(width) - 0.5f &&
                place.y < float(height) - 0.5f && !IsNaN(motion.x) && !IsNaN(motion.y);
  if (!inside) {
    return now;
  }
  vec3 low = now;
  vec3 high = now;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      vec3 c = Load(p + ivec2(dx, dy));
      low = min(low, c);
      high = max(high, c);
    }
  }
  float ratio = antialias.follow_light != 0 ? RatioAt(p) : 1.0f;
  vec3 before = min(max(ratio * SamplePrevious(place), low), high);
  float alpha = antialias.weigh_by_length != 0
                    ? NewPictureWeight(ConfidentAlpha(antialias.taa_alpha, Confidence(p)),
                                       LongestAround(p), GivenSamples(p))
                    : antialias.taa_alpha;
  if (antialias.tone_scale > 0.0f) {
    float scale = antialias.tone_scale / picture_exposure;
    return vec3(BlendTonemapped(before.x, now.x, alpha, scale),
                BlendTonemapped(before.y, now.y, alpha, scale),
                BlendTonemapped(before.z, now.z, alpha, scale));
  }
  return before + alpha * (now - before);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  vec3 c = Load(p);
  if (has_picture != 0) {
    c = Antialiased(p, c);
  }
  imageStore(picture_out, p, Stored(vec4(c, 1.0f)));
  vec4 result = vec4(c / picture_exposure, 1.0f);
  if (colour_is_half != 0) {
    imageStore(colour_half, p,
               Stored(vec4(clamp(result.xyz, vec3(-65504.0f), vec3(65504.0f)), 1.0f)));
  } else {
    imageStore(colour_float, p, result);
  }
}
