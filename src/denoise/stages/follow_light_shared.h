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

// Light is compared at one pixel of each block of this many pixels a side.
const int kFollowBlock = 4;
// The change of a block is the mean over the blocks within this distance that show its surface ...
const int kFollowRadius = 2;
// ... of which at least this many are known.
const float kFollowKnown = 6.0f;
// The surface of another block is the same up to this relative inverse depth and cosine.
const float kFollowDepth = 0.05f;
const float kFollowCosine = 0.7f;
// Light is not compared beside another surface within this many pixels along an axis: the last
// frame's block that is nearest to a place may show that surface. Pixels of a wall behind dark bars
// would be compared with the bars, but bars not with the wall, so that the wall would become
// brighter in every frame.
const int kFollowClear = 3;
const float kFollowStep = 0.02f;  // relative difference of inverse depth of another surface
// Light that moves with a reflection, not with its surface, by more pixels than this is not
// compared.
const float kMostMotionApart = 0.1f;
// How many variances of the mean change count as noise: the noise of a filter that is wider than a
// block is correlated between blocks.
const float kFollowNoise = 4.0f;
// A mean change of this size is noise, as logarithm per frame.
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

// The block whose pixel is nearest to a place, along one axis.
SHARED_FN int FollowNearest(float place, int blocks) {
  float block = (place - 0.5f * float(kFollowBlock)) / float(kFollowBlock);
  return clamp(int(floor(block + 0.5f)), 0, blocks - 1);
}

// Whether one of two pixels, as far from here on opposite sides, shows another surface, by inverse
// depths: on a plane their mean is that of the pixel between them.
SHARED_FN bool IsBesideSurface(float here, float a, float b) {
  return abs(a + b - 2.0f * here) > kFollowStep * here;
}

// Logarithm of the ratio by which the last picture is multiplied, from the changes of blocks. Light
// that moves or dims changes its whole surroundings, the noise of the filter does not.
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
