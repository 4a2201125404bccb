// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The history of a pixel: see stages/reproject.h. Loops over taps are unrolled, so that weights
// stay in registers, and the four bilinear taps are loaded before the first one is used, so that
// their latencies overlap. Include after common.glsl.
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/reproject_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform utexture2D surface_before;
layout(set = 1, binding = 3) uniform utexture2D detail_before;
layout(set = 1, binding = 4) uniform texture2DArray colour;
layout(set = 1, binding = 5) uniform texture2DArray behind;
layout(set = 1, binding = 6) uniform texture2DArray moments;
layout(set = 1, binding = 7) uniform texture2DArray compressed;

// Up to nine taps: 3x3 pixels starting at `origin`, which include the four bilinear taps.
struct Taps {
  ivec2 origin;
  float weight[9];
  bool found;
  bool searched;  // else only the four bilinear taps have weights
};

ivec2 BilinearStep(int i) {
  return ivec2(i & 1, i >> 1);
}

// The surface of the last frame at a pixel; outside the image that of its edge.
struct Before {
  Surface surface;
  uint id;
};

Before LoadBefore(ivec2 q) {
  q = ClampToPicture(q);
  Before before;
  before.surface = UnpackSurface(texelFetch(surface_before, q, 0));
  before.id = reproject.history_id != 0
                  ? UnpackDetail(texelFetch(detail_before, q, 0), before.surface.inverse_depth).id
                  : 0u;
  return before;
}

// Whether a tap matches; the surface must have its HistoryNormal.
bool TapMatches(Surface s, Detail d, vec2 place, ivec2 q, Before before) {
  vec2 offset = vec2(q) - place;
  float expected = s.inverse_depth + d.gradient.x * offset.x + d.gradient.y * offset.y;
  return Inside(q) && IsSameSurface(expected, before.surface.inverse_depth, d.gradient,
                                    dot(s.normal, before.surface.normal), d.id, before.id,
                                    reproject.history_depth, reproject.history_normal_cosine,
                                    reproject.history_id != 0);
}

// Finds the four bilinear taps; those that do not match have weight 0.
void FindBilinearTaps(Surface s, Detail d, vec2 place, inout Taps taps) {
  bool nearest = reproject.history_taps_nearest != 0;
  vec2 corner = vec2(FirstTap(place.x, nearest), FirstTap(place.y, nearest));
  vec2 t = nearest ? vec2(0.0f) : place - corner;
  taps.origin = ivec2(corner);
  Before before[4];
  [[unroll]] for (int i = 0; i < 4; ++i) {
    before[i] = LoadBefore(taps.origin + BilinearStep(i));
  }
  float sum = 0.0f;
  [[unroll]] for (int i = 0; i < 4; ++i) {
    ivec2 step_to = BilinearStep(i);
    float w = (step_to.x == 1 ? t.x : 1.0f - t.x) * (step_to.y == 1 ? t.y : 1.0f - t.y);
    w = TapMatches(s, d, place, taps.origin + step_to, before[i]) ? w : 0.0f;
    taps.weight[step_to.y * 3 + step_to.x] = w;
    sum += w;
  }
  // Taps with a tiny weight are unreliable: normalisation would scale the weight up by more than a
  // hundred.
  taps.found = sum > 0.01f;
  float scale = taps.found ? sum : 1.0f;
  [[unroll]] for (int i = 0; i < 5; ++i) {
    taps.weight[i] = taps.found ? taps.weight[i] / scale : 0.0f;
  }
}

// Finds all matching taps among the nine around the position.
void SearchTaps(Surface s, Detail d, vec2 place, inout Taps taps) {
  taps.searched = true;
  taps.origin = ivec2(floor(place + 0.5f)) - 1;
  [[unroll]] for (int i = 0; i < 9; ++i) {
    ivec2 q = taps.origin + ivec2(i % 3, i / 3);
    bool matches = TapMatches(s, d, place, q, LoadBefore(q));
    taps.weight[i] = matches ? 1.0f : 0.0f;
    taps.found = taps.found || matches;
  }
}

Taps FindTaps(ivec2 p) {
  Taps taps;
  taps.origin = ivec2(0);
  taps.found = false;
  taps.searched = false;
  [[unroll]] for (int i = 0; i < 9; ++i) {
    taps.weight[i] = 0.0f;
  }
  Surface s = UnpackSurface(texelFetch(surface_image, p, 0));
  Detail d = UnpackDetail(texelFetch(detail_image, p, 0), s.inverse_depth);
  vec2 motion = texelFetch(motion_image, p, 0).xy;
  vec2 place = vec2(p) + motion;
  // Farther than one pixel outside the image, no tap is inside.
  bool near_picture = place.x > -2.0f && place.y > -2.0f && place.x < float(width) + 1.0f &&
                      place.y < float(height) + 1.0f && !IsNaN(motion.x) && !IsNaN(motion.y);
  if (!near_picture || !(s.inverse_depth > 0.0f)) {
    return taps;
  }
  if (has_previous_normal != 0) {
    s.normal = HistoryNormal(s.normal, texelFetch(previous_normal_image, p, 0).xyz);
  }
  FindBilinearTaps(s, d, place, taps);
  if (!taps.found && reproject.history_search != 0) {
    SearchTaps(s, d, place, taps);
  }
  return taps;
}

struct History {
  vec4 moments;
  vec4 colour;
  vec4 behind;
  float compressed;
};

// A compressed luminance of the history, converted to this frame's scale. Applied before taps are
// averaged, since a mean cannot be rescaled.
float RescaledCompressed(float c, int s) {
  return old_compressed_scale[s] > 0.0f && old_compressed_scale[s] != compressed_scale[s]
             ? RescaleCompressed(c, old_compressed_scale[s], compressed_scale[s])
             : c;
}

History LoadHistory(ivec2 q, int s) {
  ivec3 at = ivec3(ClampToPicture(q), s);
  History h;
  h.moments = texelFetch(moments, at, 0);
  h.colour = texelFetch(colour, at, 0);
  h.behind = with_behind != 0 ? texelFetch(behind, at, 0) : vec4(0.0f);
  h.compressed =
      with_compressed != 0 ? RescaledCompressed(texelFetch(compressed, at, 0).x, s) : 0.0f;
  return h;
}

// Weighted sums of the history: of the length over all taps, of other planes over taps with
// samples.
struct Sums {
  History history;
  float all;
  float lit;
  float history_length;
};

void AddTap(float w, History h, inout Sums sums) {
  if (!(w > 0.0f)) {
    return;
  }
  sums.all += w;
  sums.history_length += w * max(h.moments.z, 0.0f);
  if (!(h.moments.z > 0.0f)) {
    return;
  }
  sums.lit += w;
  h.moments.y = VarianceOf(h.moments.y);
  sums.history.moments += w * h.moments;
  sums.history.colour += w * h.colour;
  sums.history.behind += w * h.behind;
  sums.history.compressed += w * h.compressed;
}

Sums SumTaps(Taps taps, int s) {
  Sums sums = Sums(History(vec4(0.0f), vec4(0.0f), vec4(0.0f), 0.0f), 0.0f, 0.0f, 0.0f);
  if (!taps.found) {
    return sums;
  }
  if (taps.searched) {
    [[unroll]] for (int i = 0; i < 9; ++i) {
      if (taps.weight[i] > 0.0f) {
        AddTap(taps.weight[i], LoadHistory(taps.origin + ivec2(i % 3, i / 3), s), sums);
      }
    }
    return sums;
  }
  History loaded[4];
  [[unroll]] for (int i = 0; i < 4; ++i) {
    loaded[i] = LoadHistory(taps.origin + BilinearStep(i), s);
  }
  [[unroll]] for (int i = 0; i < 4; ++i) {
    AddTap(taps.weight[BilinearStep(i).y * 3 + BilinearStep(i).x], loaded[i], sums);
  }
  return sums;
}

// The history in the format of its images: with deviations, at this frame's exposure. Without
// history the length is -1.
struct Fetched {
  vec3 colour;
  vec4 moments;
  vec3 behind;
  float compressed;
};

// Weighted means of all planes of the history; without history if the confidence is 0.
Fetched Fetch(Taps taps, float confidence, int s) {
  Sums sums = SumTaps(taps, s);
  History h = sums.history;
  float scale = sums.lit > 0.0f && confidence > 0.0f ? 1.0f / sums.lit : 0.0f;
  float ratio = exposure_ratio[s];
  float deviation = PackDeviation(h.moments.y * scale, true) * ratio;
  float history_length = sums.all > 0.0f ? ConfidentLength(sums.history_length / sums.all,
                                                           h.moments.w * scale, confidence)
                                         : -1.0f;
  Fetched fetched;
  fetched.colour = Stored(vec4(ClampLight(h.colour.xyz * (scale * ratio)), 0.0f)).xyz;
  fetched.moments = Stored(vec4(clamp(h.moments.x * scale * ratio, -kMostLight, kMostLight),
                                min(deviation, kMostLight), history_length, h.moments.w * scale));
  fetched.behind = Stored(vec4(ClampLight(h.behind.xyz * (scale * ratio)), 0.0f)).xyz;
  fetched.compressed = h.compressed * scale;
  return fetched;
}
