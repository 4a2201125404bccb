// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>

#include "core/parallel.h"
#include "stillray/image.h"

namespace stillray {

/// Copies the pixels, not the border. Both images must have one size.
template <typename Basis>
void CopyImage(const Planes<float, 3, Basis>& from, Planes<float, 3, Basis>* to) {
  ParallelRows(from.height(), 32, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c) {
      for (int y = y0; y < y1; ++y) {
        std::copy_n(from[c].Row(y), from.width(), (*to)[c].Row(y));
      }
    }
  });
}

}  // namespace stillray
