// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The taps of a level of the wavelet, in pairs at opposite offsets.
#pragma once

#include <cstddef>

namespace stillray {

/// The tap at (dx, dy) pixels and that at (-dx, -dy).
struct TapPair {
  float dx;
  float dy;
  float log2_kernel;
  ptrdiff_t distance;  ///< in the planes, of the first; the second lies as far on the other side
};

/// All taps but the centre.
struct TapPairs {
  static constexpr int kMost = 12;  ///< of a 5x5 kernel
  TapPair pair[kMost];
  int count = 0;
  float centre_kernel = 0;
};

/// \param radius  1: the kernel is the outer product of (1/4 1/2 1/4), 2: of (1/16 1/4 3/8 1/4
/// 1/16) \param stride  of the planes
inline TapPairs MakeTapPairs(int radius, int step, ptrdiff_t stride) {
  constexpr float kLog2Kernel3[2] = {-1.0f, -2.0f};
  constexpr float kLog2Kernel5[3] = {-1.41503750f, -2.0f, -4.0f};
  const float* log2_kernel = radius == 1 ? kLog2Kernel3 : kLog2Kernel5;
  TapPairs taps;
  taps.centre_kernel = radius == 1 ? 0.25f : 9.0f / 64.0f;
  for (int j = 0; j <= radius; ++j) {
    for (int i = j == 0 ? 1 : -radius; i <= radius; ++i) {
      taps.pair[taps.count++] = {static_cast<float>(i * step), static_cast<float>(j * step),
                                 log2_kernel[i < 0 ? -i : i] + log2_kernel[j],
                                 j * step * stride + i * step};
    }
  }
  return taps;
}

}  // namespace stillray
