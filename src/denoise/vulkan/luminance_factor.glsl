// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/edge_stopping_shared.h"

// A luminance factor is stored as its inverse, which has the range of radiance.
const float kNoLuminanceWeight = 6e4f;
#ifdef STILLRAY_HALF
const float kLeastReach = 6e-8f;  // the smallest positive half
#else
const float kLeastReach = 1e-30f;
#endif
float PackLuminanceFactor(float factor) {
  return factor > 0.0f ? clamp(1.0f / factor, kLeastReach, kNoLuminanceWeight) : kNoLuminanceWeight;
}
float UnpackLuminanceFactor(float packed) {
  return packed >= kNoLuminanceWeight ? 0.0f : 1.0f / max(packed, kLeastReach);
}
