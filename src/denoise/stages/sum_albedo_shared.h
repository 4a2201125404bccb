// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of sum_albedo.
#ifndef STILLRAY_DENOISE_SUM_ALBEDO_SHARED_H
#define STILLRAY_DENOISE_SUM_ALBEDO_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// The range of the albedo is computed per block of this many pixels along a side, over the block
// and its eight neighbours.
const int kAlbedoBlock = 4;
SHARED_FN int AlbedoBlocks(int size) {
  return (size + kAlbedoBlock - 1) / kAlbedoBlock;
}

// Virtual images whose depths differ by at most this factor are images of one surface.
const float kOneImage = 1.05f;

// Whether the blocks around a pixel with a virtual image contain another virtual image, or pixels
// without one. image: depth of the pixel's virtual image; nearest, farthest: range of the depths in
// the blocks, 0 for pixels without virtual image.
SHARED_FN bool IsBesideImage(float image, float nearest, float farthest) {
  return image > 0.0f && farthest > kOneImage * nearest;
}

// As IsBesideImage, from binary logarithms of the depths, which half precision can store in any
// unit; kNoImage for pixels without virtual image.
const float kNoImage = -1000.0f;
const float kFarthestImage = 100.0f;
const float kLogOneImage = 0.0703893278f;  // of kOneImage
SHARED_FN bool IsBesideImageByLog(float image, float nearest, float farthest) {
  return image > kNoImage && farthest - nearest > kLogOneImage;
}

SHARED_END

#endif
