// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Loops over the pixels of a picture.
#pragma once

#include "core/parallel.h"

namespace stillray {

/// Calls body(x, y) for every pixel, from several threads.
template <typename Body>
void ForEachPixel(int width, int height, const Body& body) {
  constexpr int kRowsPerTask = 16;
  ParallelRows(height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        body(x, y);
      }
    }
  });
}

}  // namespace stillray
