// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of restore_energy.
#ifndef STILLRAY_DENOISE_RESTORE_ENERGY_SHARED_H
#define STILLRAY_DENOISE_RESTORE_ENERGY_SHARED_H

#include "denoise/stages/limit_history_shared.h"

SHARED_BEGIN

SHARED_BLOCK(RestoreEnergyParameters) {
  int energy_signals;  // bit s: the stage runs for signal s
  int image_signals;   // bit s: ... and changes only pixels with guides of a virtual image
};

// Squared difference of the means of a block before and after the filter, which is the estimate of
// the difference's noise.
SHARED_FN float EnergyNoise(float accumulated, float filtered) {
  float d = accumulated - filtered;
  return d * d;
}

// Ratio of accumulated to filtered luminance, from their means over a neighbourhood.
SHARED_FN float EnergyRatio(float accumulated, float filtered, float noise) {
  return ShrunkenRatio(accumulated, filtered, noise);
}

SHARED_END

#endif
