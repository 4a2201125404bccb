// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Arguments of the SIMD versions of accumulate.
#pragma once

#include "denoise/stages/accumulate.h"

namespace stillray {

/// The inputs and parameters of accumulation.
struct Joining {
  const NewLight& light;
  const SignalHistory& before;
  const ReprojectionTaps* taps;
  const HistoryLimits& limits;
  const AccumulateParameters& p;
  float compressed_scale;  ///< of the new history; 0: no compressed luminances are stored
};

/// One row of this frame's samples.
struct LightRow {
  const float* colour[3];
  const float* samples;
};

inline LightRow LightRowOf(const NewLight& light, int y) {
  return {{light.colour[0].Row(y), light.colour[1].Row(y), light.colour[2].Row(y)},
          light.samples.Row(y)};
}

}  // namespace stillray
