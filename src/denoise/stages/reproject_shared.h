// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of reproject.
#ifndef STILLRAY_DENOISE_REPROJECT_SHARED_H
#define STILLRAY_DENOISE_REPROJECT_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

#include "denoise/stages/select_guides_shared.h"

SHARED_BEGIN

SHARED_BLOCK(ReprojectParameters) {
  float history_depth;          // relative
  float history_normal_cosine;  // minimum, between normals
  int history_id;               // 1: ids must agree
  int history_search;           // 1: the 3x3 fall-back
  int history_taps_nearest;     // 1: one tap instead of four bilinear taps
};

// Jitter and the rounding of motion move a tap by up to about one pixel along a slope.
const float kReprojectSlack = 1.5f;

// The first of the 2x2 taps along an axis: the pixel before position `place`, or the nearest pixel,
// which is then the only tap.
SHARED_FN float FirstTap(float place, bool nearest) {
  return floor(nearest ? place + 0.5f : place);
}

// Whether a tap of the previous frame shows the expected surface. expected: inverse depth of the
// plane through the current pixel, g: its gradient; i: inverse depth of the tap; ids of 0 are
// unknown.
SHARED_FN bool IsSameSurface(float expected, float i, vec2 g, float cosine, uint id, uint tap_id,
                             float depth_tolerance, float min_cosine, bool test_id) {
  float allowed = depth_tolerance * expected + kReprojectSlack * (abs(g.x) + abs(g.y));
  bool depth_ok = i > 0.0f && abs(i - expected) <= allowed;
  bool normal_ok = cosine >= min_cosine;
  bool id_ok = !test_id || id == 0u || tap_id == 0u || id == tap_id;
  return depth_ok && normal_ok && id_ok;
}

// The expected normal of a point's history: the point's normal in the last frame, if given, else
// its normal in this frame.
SHARED_FN vec3 HistoryNormal(vec3 now, vec3 previous) {
  float length2 = dot(previous, previous);
  return IsNormalLength2(length2) ? previous / sqrt(length2) : now;
}

// The confidence in the last frame's radiance, from the caller's value: clamped to 0..1, NaN counts
// as 1.
SHARED_FN float UsedConfidence(float given, bool is_nan) {
  return is_nan ? 1.0f : min(max(given, 0.0f), 1.0f);
}

// The weight of the new frame (or image) under a confidence in the history: the ratio (1 - alpha) /
// alpha of the weights of history and new frame is multiplied by the confidence.
SHARED_FN float ConfidentAlpha(float alpha, float confidence) {
  float raised = alpha / max(alpha + confidence * (1.0f - alpha), 1e-30f);
  return confidence < 1.0f ? raised : alpha;
}

// The effective length of a history under a confidence. Its upper bound is 1 / weights2, the
// effective number of samples, which alpha_min limits: without the bound a long history would stay
// long.
SHARED_FN float ConfidentLength(float length, float weights2, float confidence) {
  float most = 1.0f / max(weights2, 1e-6f);
  return confidence < 1.0f ? confidence * min(length, most) : length;
}

SHARED_END

#endif
