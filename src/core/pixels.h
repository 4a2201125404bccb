// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Loops over the pixels of a picture, and vectors of its planes.
#pragma once

#include "core/parallel.h"
#include "stillray/image.h"
#include "stillray/vec.h"

namespace stillray {

/// Calls body(x, y) for every pixel, from several threads.
template <typename Body>
void ForEachPixel(int width, int height, const Body& body) {
  ParallelRows(height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        body(x, y);
      }
    }
  });
}

inline vec3 VectorAt(const Image3& image, int x, int y) {
  return {image[0](x, y), image[1](x, y), image[2](x, y)};
}

}  // namespace stillray
