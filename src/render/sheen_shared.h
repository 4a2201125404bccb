// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The sheen of cloth: Estevez and Kulla (2017), "Production Friendly Microfacet Sheen BRDF", as in
// KHR_materials_sheen: an inverted Gaussian-like distribution ("Charlie") whose shadowing is fitted
// to that of the microfacets.
#ifndef STILLRAY_RENDER_SHEEN_SHARED_H
#define STILLRAY_RENDER_SHEEN_SHARED_H

#ifdef __cplusplus
#include "render/energy_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Minimum sheen roughness: smoother sheen would be visible only within one degree of the horizon,
// where its albedo exceeds 1.
const float kSheenLeastRoughness = 0.1f;

SHARED_FN float SheenAlpha(float roughness) {
  float least = max(roughness, kSheenLeastRoughness);
  return least * least;
}

// Maps the sheen roughness, from its minimum to 1, to the perceptual roughness that indexes the
// rows of the directional albedo table.
SHARED_FN float RowOfSheen(float roughness) {
  float part =
      (max(roughness, kSheenLeastRoughness) - kSheenLeastRoughness) / (1.0f - kSheenLeastRoughness);
  return kEnergyLeastRoughness + part * (1.0f - kEnergyLeastRoughness);
}
SHARED_FN float SheenOfRow(float row) {
  float part = (row - kEnergyLeastRoughness) / (1.0f - kEnergyLeastRoughness);
  return kSheenLeastRoughness + part * (1.0f - kSheenLeastRoughness);
}

// Distribution of microfacet normals (eq. 2); \param sine2  squared sine of the angle between
// microfacet and surface normal
SHARED_FN float SheenDensity(float sine2, float alpha) {
  return (2.0f + 1.0f / alpha) * (0.5f * kInvPi) * pow(sine2, 0.5f / alpha);
}

SHARED_FN float SheenFit(float x, float alpha) {
  float smooth_part = (1.0f - alpha) * (1.0f - alpha);
  float a = 21.5473f + (25.3245f - 21.5473f) * smooth_part;
  float b = 3.82987f + (3.32435f - 3.82987f) * smooth_part;
  float c = 0.19823f + (0.16801f - 0.19823f) * smooth_part;
  float d = -1.97760f + (-1.27393f + 1.97760f) * smooth_part;
  float e = -4.32054f + (-4.85967f + 4.32054f) * smooth_part;
  return a / (1.0f + b * pow(x, c)) + d * x + e;
}

// The fit of Smith's Lambda (eq. 3).
SHARED_FN float SheenLambda(float cosine, float alpha) {
  float fit = cosine < 0.5f ? SheenFit(cosine, alpha)
                            : 2.0f * SheenFit(0.5f, alpha) - SheenFit(1.0f - cosine, alpha);
  return exp(fit);
}

// BRDF times cos of white sheen, for directions above the surface.
SHARED_FN float EvaluateSheen(vec3 wo, vec3 wi, float alpha) {
  vec3 m = wo + wi;
  float across2 = m.x * m.x + m.y * m.y;
  float sine2 = across2 / (across2 + m.z * m.z);
  float shadowing = 1.0f + SheenLambda(wo.z, alpha) + SheenLambda(wi.z, alpha);
  return SheenDensity(sine2, alpha) / (4.0f * wo.z * shadowing);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_SHEEN_SHARED_H
