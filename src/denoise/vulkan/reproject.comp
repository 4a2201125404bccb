// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// reproject: see stages/reproject.h. Finds each pixel's taps once and fetches the history of all
// signals along them. Without history the length is -1. Sums of the last frame's luminances over
// each workgroup measure the brightness of the history.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/reproject_shared.h"
#include "denoise/vulkan/reduce.glsl"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform utexture2D surface_before;
layout(set = 1, binding = 3) uniform utexture2D detail_before;
layout(set = 1, binding = 4) uniform texture2DArray colour;
layout(set = 1, binding = 5) uniform texture2DArray behind;
layout(set = 1, binding = 6) uniform texture2DArray moments;
layout(set = 1, binding = 7) uniform texture2DArray compressed;
layout(set = 1, binding = 8, LIGHT_FORMAT) writeonly uniform image2DArray colour_out;
layout(set = 1, binding = 9, LIGHT_FORMAT) writeonly uniform image2DArray behind_out;
layout(set = 1, binding = 10, LIGHT_FORMAT) writeonly uniform image2DArray moments_out;
layout(set = 1, binding = 11, FRACTION_FORMAT) writeonly uniform image2DArray compressed_out;

// Up to nine taps of the 3x3 pixels from `origin` on; the bilinear four among them.
struct Taps {
  ivec2 origin;
  float weight[9];
  bool found;
};

// The surface has the normal that its history shows.
bool TapMatches(Surface s, Detail d, vec2 place, ivec2 q) {
  if (!Inside(q)) {
    return false;
  }
  Surface before = UnpackSurface(texelFetch(surface_before, q, 0));
  uint id_before = UnpackDetail(texelFetch(detail_before, q, 0), before.inverse_depth).id;
  vec2 offset = vec2(q) - place;
  float expected = s.inverse_depth + d.gradient.x * offset.x + d.gradient.y * offset.y;
  return IsSameSurface(expected, before.inverse_depth, d.gradient, dot(s.normal, before.normal),
                       d.id, id_before, reproject.history_depth, reproject.history_normal_cosine,
                       reproject.history_id != 0);
}

Taps FindTaps(ivec2 p) {
  Taps taps;
  taps.origin = ivec2(0);
  taps.found = false;
  for (int i = 0; i < 9; ++i) {
    taps.weight[i] = 0.0f;
  }
  Surface s = UnpackSurface(texelFetch(surface_image, p, 0));
  vec2 motion = texelFetch(motion_image, p, 0).xy;
  vec2 place = vec2(p) + motion;
  // If it is more than one pixel outside, no tap is inside.
  bool near_picture = place.x > -2.0f && place.y > -2.0f && place.x < float(width) + 1.0f &&
                      place.y < float(height) + 1.0f && !IsNaN(motion.x) && !IsNaN(motion.y);
  if (!near_picture || !(s.inverse_depth > 0.0f)) {
    return taps;
  }
  Detail d = UnpackDetail(texelFetch(detail_image, p, 0), s.inverse_depth);
  if (has_previous_normal != 0) {
    s.normal = HistoryNormal(s.normal, texelFetch(previous_normal_image, p, 0).xyz);
  }
  bool nearest = reproject.history_taps_nearest != 0;
  vec2 corner = vec2(FirstTap(place.x, nearest), FirstTap(place.y, nearest));
  vec2 t = nearest ? vec2(0.0f) : place - corner;
  taps.origin = ivec2(corner);
  float sum = 0.0f;
  for (int i = 0; i < 4; ++i) {
    ivec2 step_to = ivec2(i & 1, i >> 1);
    float w = (step_to.x == 1 ? t.x : 1.0f - t.x) * (step_to.y == 1 ? t.y : 1.0f - t.y);
    w = TapMatches(s, d, place, taps.origin + step_to) ? w : 0.0f;
    taps.weight[step_to.y * 3 + step_to.x] = w;
    sum += w;
  }
  // Taps with a tiny weight are not reliable: the weight would be scaled up a hundredfold.
  if (sum > 0.01f) {
    for (int i = 0; i < 5; ++i) {
      taps.weight[i] /= sum;
    }
    taps.found = true;
    return taps;
  }
  for (int i = 0; i < 5; ++i) {
    taps.weight[i] = 0.0f;
  }
  if (reproject.history_search != 0) {
    taps.origin = ivec2(floor(place + 0.5f)) - 1;
    for (int i = 0; i < 9; ++i) {
      bool matches = TapMatches(s, d, place, taps.origin + ivec2(i % 3, i / 3));
      taps.weight[i] = matches ? 1.0f : 0.0f;
      taps.found = taps.found || matches;
    }
  }
  return taps;
}

// Weighted means of the whole history: the length over all taps, other planes over those with
// light; none without confidence in it.
void Fetch(Taps taps, float confidence, ivec2 p, int s) {
  vec4 sum_colour = vec4(0.0f);
  vec4 sum_behind = vec4(0.0f);
  vec4 sum_moments = vec4(0.0f);
  float sum_compressed = 0.0f;
  float all = 0.0f;
  float lit = 0.0f;
  float sum_length = 0.0f;
  for (int i = 0; i < 9; ++i) {
    float w = taps.weight[i];
    if (!(w > 0.0f)) {
      continue;
    }
    ivec3 q = ivec3(taps.origin + ivec2(i % 3, i / 3), s);
    vec4 m = texelFetch(moments, q, 0);
    all += w;
    sum_length += w * max(m.z, 0.0f);
    if (!(m.z > 0.0f)) {
      continue;
    }
    lit += w;
    m.y = VarianceOf(m.y);
    sum_moments += w * m;
    sum_colour += w * texelFetch(colour, q, 0);
    if (with_behind != 0) {
      sum_behind += w * texelFetch(behind, q, 0);
    }
    if (with_compressed != 0) {
      sum_compressed += w * texelFetch(compressed, q, 0).x;
    }
  }
  float scale = lit > 0.0f && confidence > 0.0f ? 1.0f / lit : 0.0f;
  float ratio = exposure_ratio[s];
  vec3 c = ClampLight(sum_colour.xyz * (scale * ratio));
  float deviation = PackDeviation(sum_moments.y * scale, true) * ratio;
  float history_length =
      all > 0.0f ? ConfidentLength(sum_length / all, sum_moments.w * scale, confidence) : -1.0f;
  ivec3 at = ivec3(p, s);
  imageStore(colour_out, at, Stored(vec4(c, 0.0f)));
  imageStore(moments_out, at,
             Stored(vec4(clamp(sum_moments.x * scale * ratio, -kMostLight, kMostLight),
                         min(deviation, kMostLight), history_length, sum_moments.w * scale)));
  if (with_behind != 0) {
    imageStore(behind_out, at, Stored(vec4(ClampLight(sum_behind.xyz * (scale * ratio)), 0.0f)));
  }
  if (with_compressed != 0) {
    imageStore(compressed_out, at, vec4(sum_compressed * scale));
  }
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  vec4 luminance = vec4(0.0f);
  if (Inside(p)) {
    Taps taps = FindTaps(p);
    float confidence = Confidence(p);
    for (int s = 0; s < signals; ++s) {
      Fetch(taps, confidence, p, s);
      luminance[s] = texelFetch(colour, ivec3(p, s), 0).x * exposure_ratio[s];
    }
  }
  luminance = SumOfGroup(luminance);
  if (gl_LocalInvocationIndex == 0u) {
    partials[2u * GroupIndex() + 1u] = luminance;
  }
}
