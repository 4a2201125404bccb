// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of sum_albedo.
#ifndef STILLRAY_DENOISE_SUM_ALBEDO_SHARED_H
#define STILLRAY_DENOISE_SUM_ALBEDO_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// The range of the albedo is that of blocks of this many pixels a side, with the blocks next to
// them.
const int kAlbedoBlock = 4;
SHARED_FN int AlbedoBlocks(int size) {
  return (size + kAlbedoBlock - 1) / kAlbedoBlock;
}

// Images whose depths differ by no more than this factor are those of one surface.
const float kOneImage = 1.05f;

// Whether a pixel that shows an image has another one, or none, in these blocks. Depths of the
// images, 0 for pixels without: of the pixel, and the range in the blocks.
SHARED_FN bool IsBesideImage(float image, float nearest, float farthest) {
  return image > 0.0f && farthest > kOneImage * nearest;
}

// The same of binary logarithms, which halves can hold of depths in any unit: kNoImage for pixels
// without.
const float kNoImage = -1000.0f;
const float kFarthestImage = 100.0f;
const float kLogOneImage = 0.0703893278f;  // of kOneImage
SHARED_FN bool IsBesideImageByLog(float image, float nearest, float farthest) {
  return image > kNoImage && farthest - nearest > kLogOneImage;
}

SHARED_END

#endif
