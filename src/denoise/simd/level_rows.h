// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the rows of a level of the wavelet have in common.
#pragma once

#include <span>

#include "denoise/row_ring.h"
#include "denoise/simd/tap_pairs.h"
#include "denoise/stages/atrous.h"

namespace stillray {

inline constexpr size_t kMostSignals = 8;

/// Where a level reads and writes the rows of a signal: luminance, red, blue, variance.
struct LevelRows {
  const AtrousSignal* signal;
  PlaneRows<const float> in[4];
  PlaneRows<float> out[4];
  PlaneRows<float> kept[3];  ///< empty: not wanted
};

/// What rows of a level have in common.
struct AtrousLevel {
  std::span<const LevelRows> signals;
  const GuidePlanes* guides;
  const AtrousParameters* parameters;
  TapPairs taps;
  float centre_kernel;
  int advance;         ///< from a row to the one that is filtered after it
  bool leads;          ///< nobody has fetched the guides before
  int kept_begin = 0;  ///< rows that are kept
  int kept_end = 0;
};

}  // namespace stillray
