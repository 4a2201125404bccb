// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Look-ups in the energy tables of rough lobes.
#ifndef STILLRAY_RENDER_ENERGY_SHARED_H
#define STILLRAY_RENDER_ENERGY_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Entries per row and column.
const int kEnergyTableSize = 32;

// The smallest roughness of the tables; smoother lobes are treated as ideally smooth.
const float kEnergyLeastRoughness = 0.03f;

// The first of the four entries to interpolate, and the fractions along the row and the column.
struct EnergyPlace {
  int first;
  float x;
  float y;
};

// Columns are the square roots of cosines: denser towards grazing angles.
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

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_ENERGY_SHARED_H
