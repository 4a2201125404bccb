// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of picture_motion.
#ifndef STILLRAY_DENOISE_PICTURE_MOTION_SHARED_H
#define STILLRAY_DENOISE_PICTURE_MOTION_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// The most diffuse light of a surface that shows an image, relative to the light of the image.
const float kMostDiffuse = 0.1f;

// Antialiasing takes the motion of the nearest surface of 3x3 pixels, so that silhouettes stay
// smooth. They move with the surface: pixels this near to them keep its motion.
const int kSilhouette = 1;

// Whether a pixel shows little but an image. Luminances of the albedos: `diffuse` of the surface,
// `seen` of the light of the image, `other` of that of the other image: glass shows one by
// reflection, one by transmission.
SHARED_FN bool ShowsLittleElse(float surface_depth, float selected_depth, float diffuse, float seen,
                               float other) {
  return selected_depth != surface_depth && diffuse < kMostDiffuse * seen && other <= seen;
}

// Whether the motion of an image is known: what was out of sight has one that leads out of the
// picture, or NaN.
SHARED_FN bool HasImageMotion(float motion_x, float picture_width) {
  return abs(motion_x) < picture_width;
}

// Whether the image at a neighbour of a pixel is another one in front of its own, by the depths of
// both and of the image at the pixel opposite to the neighbour: inverse depths of a plane have no
// second difference.
const float kImageStep = 0.05f;
SHARED_FN bool StandsInFrontOfImage(float depth, float neighbour, float opposite) {
  return neighbour < depth && depth / neighbour + depth / opposite - 2.0f > kImageStep;
}

// Difference of two motions in pixels along an axis, from which one does not count for the other:
// in curved surfaces images move differently at every pixel.
const float kMostMotionStep = 4.0f;
SHARED_FN bool MovesNearly(vec2 motion, vec2 other) {
  return max(abs(motion.x - other.x), abs(motion.y - other.y)) < kMostMotionStep;
}

// Depth of the image that a pixel shows and little else; 0: none. The sky is finite.
SHARED_FN float ShownImage(float selected_depth, bool shows_little_else) {
  return shows_little_else ? min(selected_depth, 1e30f) : 0.0f;
}

// Whether a neighbour of a surface is another one by its depth.
SHARED_FN bool IsOtherSurface(float depth, float neighbour) {
  return abs(neighbour - depth) > 0.1f * depth;
}

SHARED_END

#endif
