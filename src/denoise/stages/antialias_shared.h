// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of antialias.
#ifndef STILLRAY_DENOISE_ANTIALIAS_SHARED_H
#define STILLRAY_DENOISE_ANTIALIAS_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(AntialiasParameters) {
  float taa_alpha;      // weight of the new frame
  int weigh_by_length;  // 1: light with a short history has a larger one
  int spline;           // 1: the last picture is resampled with a B-spline, 0: Catmull-Rom
  int follow_light;     // signals that follow_light compares, the first ones; 0: it does not run
  int clamp_light;      // 1: the light of the last picture is clamped, 0: the last picture
  int image_albedo;     // 1: the albedo of reflected light is that of the images that mirrors show
  int image_length;     // 1: where a pixel shows an image the history is that of the image's light
  float tone_scale;     // pictures are blended under x / (1 + tone_scale x); 0: as linear light
};

// Whether a neighbour is in front of the surface at a pixel, rather than part of it: i are inverse
// depths, g the gradient at the pixel. On a surface seen edge-on the motion differs at every pixel,
// and using that of the nearest would distort its picture.
const float kInFront = 0.02f;
SHARED_FN bool StandsInFront(float i, float i_neighbour, vec2 g, vec2 offset) {
  return i_neighbour > i + g.x * offset.x + g.y * offset.y + kInFront * i;
}

// Weight of the new picture, whose light has `length` samples, n of them new. If the light's
// history has just started (after a disocclusion) the old picture showed another surface, even if
// it passes the clamp: it counts no more than the light's own history does. Where limit_history has
// shortened a history, that is since the light has changed by more than its noise. With many
// samples little is enough, while a picture that starts again has the jagged edges of one point per
// pixel, whatever n is: n samples count as their square root.
SHARED_FN float NewPictureWeight(float alpha, float length, float n) {
  float counted = n > 1.0f ? sqrt(n) : n;
  return n > 0.0f ? min(max(alpha, counted / max(length - (n - counted), counted)), 1.0f) : alpha;
}

// Blend of one channel of two pictures under Reinhard's curve s x / (1 + s x), s = `scale`: the
// curve of the result is the linear blend of both curves, as if antialiasing ran after the tone
// curve. The inverse curve of that blend is the mean weighted by 1 / (1 + s x) (Karis 2014, with
// luminance for x), which, other than the curve itself, is accurate for bright light.
SHARED_FN float BlendTonemapped(float before, float now, float alpha, float scale) {
  float of_before = (1.0f - alpha) / (1.0f + scale * max(before, 0.0f));
  float of_now = alpha / (1.0f + scale * max(now, 0.0f));
  return (of_before * before + of_now * now) / (of_before + of_now);
}

// Light of a picture: divided by the albedo. Without the addition, texture that is nearly black
// would have any light.
const float kTextureFloor = 0.002f;
SHARED_FN float LightOfPicture(float picture, float albedo) {
  return picture / (albedo + kTextureFloor);
}
SHARED_FN float PictureOfLight(float light, float albedo) {
  return light * (albedo + kTextureFloor);
}

// The last picture stays within the range of the picture, which is wider by as much as its albedo
// is outside that of the albedo. Reflections on dark texture are bright light: beside them nearly
// any light passes the clamp of the light.
SHARED_FN float WidenedLow(float low, float albedo, float low_albedo) {
  return low * min((albedo + kTextureFloor) / (low_albedo + kTextureFloor), 1.0f);
}
// Not where the albedo is nearly black: the sky and lamps are no light times it, and what splines
// leave of the albedo beside them would be many times as much.
const float kNoTexture = 0.02f;
SHARED_FN float WidenedHigh(float high, float albedo, float high_albedo) {
  float ratio = max((albedo + kTextureFloor) / (high_albedo + kTextureFloor), 1.0f);
  return high_albedo > kNoTexture ? high * ratio : high;
}

// The albedo of the last frame may have been another surface's, and be any albedo around, where the
// history of the light has at most this many times the samples of a frame ...
const float kYoungFrames = 4.0f;
SHARED_FN bool IsYoung(float length, float n) {
  return !(length > kYoungFrames * max(n, 1.0f));
}
// ... and where another surface is within this many pixels along an axis: splines ring there.
const int kTextureClear = 2;

// ... or was in the last frame: by the inverse depths of the pixel and of two as far from it on
// opposite sides, whose mean on a plane is that of the pixel between them.
const float kTextureStep = 0.05f;
SHARED_FN bool WasBesideSurface(float here, float a, float b) {
  return abs(a + b - 2.0f * here) > kTextureStep * here;
}

// Whether a pixel with the inverse depth `found` is on the plane of the surface at another one,
// whose inverse depth is `here` and its gradient g.
SHARED_FN bool IsOnPlane(float here, vec2 g, float found, vec2 offset) {
  return abs(found - (here + g.x * offset.x + g.y * offset.y)) <= kInFront * here;
}

// Weight of the six-tap (per axis: four) Catmull-Rom spline at distance -1-t, -t, 1-t, 2-t.
SHARED_FN vec4 CatmullRom(float t) {
  float t2 = t * t;
  float t3 = t2 * t;
  return vec4(-0.5f * t3 + t2 - 0.5f * t, 1.5f * t3 - 2.5f * t2 + 1.0f,
              -1.5f * t3 + 2.0f * t2 + 0.5f * t, 0.5f * t3 - 0.5f * t2);
}

// Weights of the cubic B-spline at the same distances.
SHARED_FN vec4 CubicSpline(float t) {
  float t2 = t * t;
  float t3 = t2 * t;
  return vec4(1.0f - 3.0f * t + 3.0f * t2 - t3, 4.0f - 6.0f * t2 + 3.0f * t3,
              1.0f + 3.0f * t + 3.0f * t2 - 3.0f * t3, t3) /
         6.0f;
}

SHARED_END

#endif
