// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Loops over the pixels of an image, and vectors from its planes.
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

/// Whether the condition holds for the value of any pixel of the plane.
template <typename T, typename Condition>
bool AnyPixel(const Plane<T>& plane, const Condition& condition) {
  for (int y = 0; y < plane.height(); ++y) {
    const T* row = plane.Row(y);
    int any = 0;  // no early exit within a row: compilers vectorise the loop
    for (int x = 0; x < plane.width(); ++x) {
      any |= static_cast<int>(condition(row[x]));
    }
    if (any != 0) {
      return true;
    }
  }
  return false;
}

/// As above, for the values of all planes of an image.
template <typename T, int N, typename Basis, typename Condition>
bool AnyPixel(const Planes<T, N, Basis>& image, const Condition& condition) {
  for (const Plane<T>& plane : image.channel) {
    if (AnyPixel(plane, condition)) {
      return true;
    }
  }
  return false;
}

inline vec3 VectorAt(const Image3& image, int x, int y) {
  return {image[0](x, y), image[1](x, y), image[2](x, y)};
}

}  // namespace stillray
