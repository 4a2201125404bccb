// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The taps of a neighbourhood, in pairs at opposite offsets.
#pragma once

#include <cstddef>
#include <span>

namespace stillray {

/// The taps at (dx, dy) and (-dx, -dy) pixels.
struct TapPair {
  float dx;
  float dy;
  float log2_kernel;
  ptrdiff_t distance;         ///< offset of the first tap in the planes; the second is at -distance
  ptrdiff_t normal_distance;  ///< offset in the normals, which may be in separate rows
};

/// All taps but the centre.
struct TapPairs {
  /// Number of pairs of a kernel of (2 radius + 1)^2 taps.
  static constexpr int CountOf(int radius) { return 2 * radius * (radius + 1); }
  static constexpr int kMost = 24;  ///< CountOf(3): 7x7
  TapPair pair[kMost];
  int count = 0;
};

/// \param log2_kernel  of one half of the separable kernel, from the centre outwards; the kernel is
///     the outer product
/// \param step         distance between taps, pixels
/// \param stride       of the planes
/// \param normal_rows  NormalWindow::RowDistance
inline TapPairs MakeTapPairs(std::span<const float> log2_kernel, int step, ptrdiff_t stride,
                             ptrdiff_t normal_rows) {
  const int radius = static_cast<int>(log2_kernel.size()) - 1;
  TapPairs taps;
  for (int j = 0; j <= radius; ++j) {
    for (int i = j == 0 ? 1 : -radius; i <= radius; ++i) {
      const auto across = static_cast<size_t>(i < 0 ? -i : i);
      taps.pair[taps.count++] = {static_cast<float>(i * step), static_cast<float>(j * step),
                                 log2_kernel[across] + log2_kernel[static_cast<size_t>(j)],
                                 j * step * stride + i * step, j * normal_rows + i * step};
    }
  }
  return taps;
}

}  // namespace stillray
