// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/edge_stopping_shared.h"

// A luminance stop as the inverse, which has the range of light.
const float kNoStop = 6e4f;
#ifdef STILLRAY_HALF
const float kLeastReach = 6e-8f;  // the least that a half holds
#else
const float kLeastReach = 1e-30f;
#endif
float PackStop(float stop) {
  return stop > 0.0f ? clamp(1.0f / stop, kLeastReach, kNoStop) : kNoStop;
}
float UnpackStop(float packed_stop) {
  return packed_stop >= kNoStop ? 0.0f : 1.0f / max(packed_stop, kLeastReach);
}
