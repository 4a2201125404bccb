// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of clip_outliers.
#ifndef STILLRAY_DENOISE_CLIP_OUTLIERS_SHARED_H
#define STILLRAY_DENOISE_CLIP_OUTLIERS_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(ClipOutliersParameters) {
  float clip_outliers;  // largest excess that counts as noise, in standard deviations
};

// Excesses below this fraction of the brighter value are not visible as specks.
const float kLeastOutlier = 0.05f;

// Whether luminance l exceeds the range of its neighbours visibly, by an amount that may be noise.
SHARED_FN bool IsOutlier(float l, float lowest, float highest, float variance, float most) {
  float excess = max(l - highest, lowest - l);
  return excess > kLeastOutlier * max(max(l, highest), 0.0f) &&
         excess * excess <= most * most * variance;
}

// Factor from the mean of the neighbours to the nearest value of their range.
SHARED_FN float ClippedScale(float l, float lowest, float highest, float mean) {
  return mean > 1e-20f ? min(max(l, lowest), highest) / mean : 1.0f;
}

SHARED_END

#endif
