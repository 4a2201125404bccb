// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of follow_light.
#ifndef STILLRAY_DENOISE_FOLLOW_LIGHT_SHARED_H
#define STILLRAY_DENOISE_FOLLOW_LIGHT_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

#include "denoise/stages/light_change_shared.h"

SHARED_BEGIN

// Radiance is compared at one pixel of each block of this many pixels along a side.
const int kFollowBlock = 4;
// The change of a block is the mean over the blocks of its surface within this distance ...
const int kFollowRadius = 2;
// ... of which at least this many are known.
const float kFollowKnown = 6.0f;
// Another block is on the same surface within this relative difference of inverse depth and above
// this cosine of normals.
const float kFollowDepth = 0.05f;
const float kFollowCosine = 0.7f;
// Radiance is not compared within this many pixels of another surface, along an axis: the nearest
// block of the last frame may show that surface. Pixels of a wall behind dark bars would be
// compared with the bars, but bars not with the wall, so that the wall would become brighter in
// every frame.
const int kFollowClear = 3;
const float kFollowStep = 0.02f;  // relative difference of inverse depth of another surface
// Radiance is not compared where the motions of reflection and surface differ by more than this, in
// pixels.
const float kMostMotionApart = 0.1f;
// The multiple of the variance of the mean change that counts as noise: the filter is wider than a
// block, so that noise is correlated between blocks.
const float kFollowNoise = 4.0f;
// A mean change up to this counts as noise, as logarithm per frame.
const float kFollowLeast = 0.006f;
// Bound of the change that is followed, as logarithm.
const float kMostFollowed = 0.6931472f;

SHARED_FN int FollowSize(int size) {
  return (size + kFollowBlock - 1) / kFollowBlock;
}

// The pixel of a block, along one axis.
SHARED_FN int FollowPixel(int block, int size) {
  return min(block * kFollowBlock + kFollowBlock / 2, size - 1);
}

// The block whose pixel is nearest to the position `place` in pixels, along one axis.
SHARED_FN int FollowNearest(float place, int blocks) {
  float block = (place - 0.5f * float(kFollowBlock)) / float(kFollowBlock);
  return clamp(int(floor(block + 0.5f)), 0, blocks - 1);
}

// Whether one of two pixels at equal distance on opposite sides shows another surface, from inverse
// depths: on a plane their mean is the inverse depth of the pixel between them.
SHARED_FN bool IsBesideSurface(float here, float a, float b) {
  return abs(a + b - 2.0f * here) > kFollowStep * here;
}

// Logarithm of the ratio by which the last image is multiplied, from the changes of blocks. A
// moving or dimming light changes all blocks around by similar ratios, the noise of the filter does
// not.
SHARED_FN float FollowedChange(float sum, float squares, float known) {
  float count = max(known, 1.0f);
  float mean = sum / count;
  float noise =
      kFollowNoise * VarianceOfChange(mean, squares / count, known) + kFollowLeast * kFollowLeast;
  float followed = clamp(ShrunkenChange(mean, noise), -kMostFollowed, kMostFollowed);
  return known >= kFollowKnown ? followed : 0.0f;
}

SHARED_END

#endif
