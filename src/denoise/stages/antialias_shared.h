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
  float taa_alpha;         // weight of the new frame
  float taa_moving_alpha;  // minimum weight where the image moves
  int weigh_by_length;     // 1: larger where the history is short
  int resampling;          // of the last image: kCatmullRom, kSpline or kSubcell
  int extrapolate_motion;  // 1: the motion at silhouettes is that of ExtrapolatedMotion
  int follow_light;        // number of signals that follow_light compares, from the first; 0: off
  int clamp_light;         // 1: the demodulated last image is clamped, 0: the image itself
  int image_albedo;        // 1: the albedo of reflected light is that of the reflected surface
  int image_length;        // 1: where a pixel shows a virtual image, its history length is used
  float tone_scale;        // images are blended under x / (1 + tone_scale x); 0: linearly
};

// Filters that resample the last image.
const int kCatmullRom = 0;
const int kSpline = 1;   // the cubic spline through the pixels
const int kSubcell = 2;  // ResampleSubcell along rows, then along columns

// Whether a neighbour is in front of the surface at a pixel, rather than part of it: i are inverse
// depths, g the gradient at the pixel. On a surface at a grazing angle the motion differs at every
// pixel, and the motion of the nearest one would distort it.
const float kInFront = 0.02f;
SHARED_FN bool StandsInFront(float i, float i_neighbour, vec2 g, vec2 offset) {
  return i_neighbour > i + g.x * offset.x + g.y * offset.y + kInFront * i;
}

// Motion of a surface at a pixel beside it, from its motion at a neighbour of that pixel and at the
// next two pixels in the same direction, if those are on the plane of the neighbour's surface
// (IsOnPlane). Where the motion changes from pixel to pixel, the motion of the neighbour differs
// from that of the silhouette by a part of this change in every frame, and the silhouette lags by
// as much, divided by the weight of the new image. The change must be that between the next two
// pixels, nearly: beside the silhouette of a mirror pixels move with the mirror, the others with
// the virtual image.
// \param neighbour, next, last  pixels per frame; may be NaN
const float kMostMotionChange = 0.5f;  // pixels per frame and pixel
const float kMostBend = 0.5f;          // difference of both changes, relative to the first
SHARED_FN vec2 ExtrapolatedMotion(vec2 neighbour, vec2 next, vec2 last) {
  vec2 change = neighbour - next;
  vec2 bend = change - (next - last);
  float largest = max(abs(change.x), abs(change.y));
  bool continues = abs(change.x) < kMostMotionChange && abs(change.y) < kMostMotionChange &&
                   abs(bend.x) <= kMostBend * largest && abs(bend.y) <= kMostBend * largest;
  return continues ? neighbour + change : neighbour;
}

// Demodulated value of an image: divided by the albedo. Without the added floor, the quotient would
// be arbitrary where the albedo is nearly black.
const float kTextureFloor = 0.002f;
SHARED_FN float LightOfPicture(float picture, float albedo) {
  return picture / (albedo + kTextureFloor);
}
SHARED_FN float PictureOfLight(float light, float albedo) {
  return light * (albedo + kTextureFloor);
}

// Minimum weight of the new image where it moves: the old image is resampled there, so that it
// lags, and blurs a little more in every frame. Where it stands still nothing is lost by a small
// weight, and edges flicker less.
// \param agreement  AlbedoAgreement; 1 if it is unknown
const float kMovingRate = 4.0f;  // of the share per pixel of motion
SHARED_FN float MovingAlpha(float alpha, float moving_alpha, vec2 motion, float agreement) {
  float share = min(kMovingRate * max(abs(motion.x), abs(motion.y)), 1.0f);
  return alpha + max(moving_alpha - alpha, 0.0f) * share * agreement;
}

// Agreement of a channel of the new albedo with the antialiased one, 0..1. They differ where the
// points of one frame do not represent their pixels: at edges, and on textures that alias.
const float kLargestDifference = 0.25f;  // relative, at which they agree no more
SHARED_FN float AlbedoAgreement(float now, float antialiased) {
  float difference = abs(now - antialiased);
  float largest = max(now, antialiased) + kTextureFloor;
  return max(1.0f - difference / (kLargestDifference * largest), 0.0f);
}

// Weight of the new image at a pixel with a history of `length` samples, n of them new. If the
// history has just started (after a disocclusion), the old image showed another surface, even if it
// passes the clamp: its weight is at most that of the history. limit_history shortens a history
// only where the radiance has changed by more than its noise. With large n a smaller weight
// suffices, while an image that starts again has the jagged edges of one point per pixel, whatever
// n is: n samples count as their square root.
SHARED_FN float NewPictureWeight(float alpha, float length, float n) {
  float counted = n > 1.0f ? sqrt(n) : n;
  return n > 0.0f ? min(max(alpha, counted / max(length - (n - counted), counted)), 1.0f) : alpha;
}

// Blend of one channel of two images under Reinhard's curve s x / (1 + s x), s = `scale`: the curve
// of the result is the linear blend of both curves, as if antialiasing ran after the tone curve.
// The inverse curve of that blend is the mean weighted by 1 / (1 + s x) (Karis 2014, with luminance
// for x), which, unlike the curve itself, is accurate for bright radiance.
SHARED_FN float BlendTonemapped(float before, float now, float alpha, float scale) {
  float of_before = (1.0f - alpha) / (1.0f + scale * max(before, 0.0f));
  float of_now = alpha / (1.0f + scale * max(now, 0.0f));
  return (of_before * before + of_now * now) / (of_before + of_now);
}

// Lower bound of the last image: that of the current image, lowered by the factor by which the last
// albedo is below the range of the current albedo. The bounds are needed beside reflections on dark
// texture: their demodulated values are so large that nearly any value passes the clamp.
SHARED_FN float WidenedLow(float low, float albedo, float low_albedo) {
  return low * min((albedo + kTextureFloor) / (low_albedo + kTextureFloor), 1.0f);
}
// Upper bound, raised likewise. It is not raised where the albedo is nearly black: sky and lamps
// are not multiplied by an albedo, and the ringing of the spline beside them would be many times as
// much.
const float kNoTexture = 0.02f;
SHARED_FN float WidenedHigh(float high, float albedo, float high_albedo) {
  float ratio = max((albedo + kTextureFloor) / (high_albedo + kTextureFloor), 1.0f);
  return high_albedo > kNoTexture ? high * ratio : high;
}

// The albedo of the last frame may be that of another surface, and have any value, where the
// history has at most this many times the samples of a frame ...
const float kYoungFrames = 4.0f;
SHARED_FN bool IsYoung(float length, float n) {
  return !(length > kYoungFrames * max(n, 1.0f));
}
// ... and where another surface is within this many pixels along an axis: splines ring there.
const int kTextureClear = 2;

// ... or was in the last frame: from the inverse depths of the pixel and of two pixels at equal
// distance on opposite sides. On a plane the mean of these two is the inverse depth of the pixel.
const float kTextureStep = 0.05f;
SHARED_FN bool WasBesideSurface(float here, float a, float b) {
  return abs(a + b - 2.0f * here) > kTextureStep * here;
}

// Whether a pixel with inverse depth `found` is on the plane of another pixel's surface, with
// inverse depth `here` and gradient g.
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

// The argument that is nearer to 0; 0 if they differ in sign.
SHARED_FN float Minmod(float a, float b) {
  return max(min(a, b), 0.0f) + min(max(a, b), 0.0f);
}

// A row of pixels a, b, c, d, resampled at distance t from b, 0..1. Every pixel is a mean over its
// area. If its value is between those of its neighbours, the row within it is taken as a step from
// one to the other, at the place that keeps the mean (subcell resolution, Harten 1989), else as
// constant; the result is the mean of that over the area of a pixel. For b the integral of the step
// over the last 1-t of the pixel is (1-t) b + Minmod(t (b-a), (1-t) (c-b)). An edge that is
// resampled in every frame thus remains within one pixel, while linear filters blur it anew. Steps
// alone turn gradients to stairs over many frames; the share of Catmull-Rom's spline prevents that.
const float kStepShare = 0.75f;
SHARED_FN float ResampleSubcell(float a, float b, float c, float d, float t) {
  float last = 1.0f - t;
  float before = b - a;
  float between = c - b;
  float after = d - c;
  float moved = t * between;
  float steps = Minmod(t * before, between - moved) - Minmod(last * after, moved);
  float cubic = -0.5f * t * last * (last * (between - before) + t * (after - between));
  return b + moved + (kStepShare * steps + (1.0f - kStepShare) * cubic);
}

// Weights of the cubic B-spline at the distances of CatmullRom.
SHARED_FN vec4 CubicSpline(float t) {
  float t2 = t * t;
  float t3 = t2 * t;
  return vec4(1.0f - 3.0f * t + 3.0f * t2 - t3, 4.0f - 6.0f * t2 + 3.0f * t3,
              1.0f + 3.0f * t + 3.0f * t2 - 3.0f * t3, t3) /
         6.0f;
}

SHARED_END

#endif
