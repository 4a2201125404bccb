// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Lookups in the directional albedo tables of rough lobes.
#ifndef STILLRAY_RENDER_ENERGY_SHARED_H
#define STILLRAY_RENDER_ENERGY_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Fraction of light reflected by a single-scattering lobe with Schlick weights.
struct SchlickShare {
  float scale;
  float offset;
};

// Entries per row and column.
const int kEnergyTableSize = 32;

// The smallest roughness of the tables; smoother lobes are treated as ideally smooth.
const float kEnergyLeastRoughness = 0.03f;

// Bilinear interpolation: the first of the four entries, and the fractions along row and column.
struct EnergyPlace {
  int first;
  float x;
  float y;
};

// Columns are spaced by the square root of the cosine: denser towards grazing angles.
SHARED_FN EnergyPlace FindEnergy(float cosine, float roughness) {
  float last = float(kEnergyTableSize - 1);
  float x = sqrt(clamp(cosine, 0.0f, 1.0f)) * last;
  float y =
      clamp((roughness - kEnergyLeastRoughness) / (1.0f - kEnergyLeastRoughness), 0.0f, 1.0f) *
      last;
  int i = min(int(x), kEnergyTableSize - 2);
  int j = min(int(y), kEnergyTableSize - 2);
  EnergyPlace place;
  place.first = j * kEnergyTableSize + i;
  place.x = x - float(i);
  place.y = y - float(j);
  return place;
}

// The table of anisotropic lobes has four dimensions: cosine with the normal, azimuth, roughness
// across the tangent, and strength of the anisotropy.
const int kAnisotropicCosines = 16;
const int kAnisotropicTurns = 6;
const int kAnisotropicRoughnesses = 12;
const int kAnisotropicStrengths = 12;
const int kAnisotropicEntries =
    kAnisotropicCosines * kAnisotropicTurns * kAnisotropicRoughnesses * kAnisotropicStrengths;

// The first of the sixteen entries to interpolate, and the fractions by cosine, azimuth, roughness
// and strength.
struct AnisotropicPlace {
  int first;
  vec4 part;
};

// Azimuths are spaced evenly in the projected roughness, of which the reflectance is a smooth
// function: 0 is across the tangent, 1 along it.
// \param w      direction to the viewer; x along the tangent
// \param alpha  x along the tangent, y across; x >= y
SHARED_FN AnisotropicPlace FindAnisotropicEnergy(vec3 w, vec2 alpha) {
  float sine2 = max(w.x * w.x + w.y * w.y, 1e-12f);
  float x = alpha.x * w.x;
  float y = alpha.y * w.y;
  float met = sqrt((x * x + y * y) / sine2);
  float stretch = max(alpha.x - alpha.y, 0.0f);
  float turn = stretch > 0.0f ? clamp((met - alpha.y) / stretch, 0.0f, 1.0f) : 0.0f;
  float roughness = (sqrt(alpha.y) - kEnergyLeastRoughness) / (1.0f - kEnergyLeastRoughness);
  float strength = sqrt(stretch / max(1.0f - alpha.y, 1e-6f));
  vec4 last = vec4(float(kAnisotropicCosines - 1), float(kAnisotropicTurns - 1),
                   float(kAnisotropicRoughnesses - 1), float(kAnisotropicStrengths - 1));
  vec4 at = vec4(sqrt(clamp(w.z, 0.0f, 1.0f)), turn, clamp(roughness, 0.0f, 1.0f),
                 clamp(strength, 0.0f, 1.0f)) *
            last;
  int i = min(int(at.x), kAnisotropicCosines - 2);
  int j = min(int(at.y), kAnisotropicTurns - 2);
  int k = min(int(at.z), kAnisotropicRoughnesses - 2);
  int l = min(int(at.w), kAnisotropicStrengths - 2);
  AnisotropicPlace place;
  place.first =
      ((l * kAnisotropicRoughnesses + k) * kAnisotropicTurns + j) * kAnisotropicCosines + i;
  place.part = vec4(at.x - float(i), at.y - float(j), at.z - float(k), at.w - float(l));
  return place;
}

// Index and weight of interpolation corner 0 to 15: its bits are the steps by cosine, azimuth,
// roughness and strength.
SHARED_FN int AnisotropicEntry(SHARED_IN(AnisotropicPlace) place, int corner) {
  int row = kAnisotropicCosines;
  int plane = row * kAnisotropicTurns;
  return place.first + (corner & 1) + (corner >> 1 & 1) * row + (corner >> 2 & 1) * plane +
         (corner >> 3 & 1) * (plane * kAnisotropicRoughnesses);
}
SHARED_FN float AnisotropicWeight(SHARED_IN(AnisotropicPlace) place, int corner) {
  vec4 p = place.part;
  return ((corner & 1) != 0 ? p.x : 1.0f - p.x) * ((corner & 2) != 0 ? p.y : 1.0f - p.y) *
         ((corner & 4) != 0 ? p.z : 1.0f - p.z) * ((corner & 8) != 0 ? p.w : 1.0f - p.w);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_ENERGY_SHARED_H
