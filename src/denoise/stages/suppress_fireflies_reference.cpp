// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "denoise/stages/suppress_fireflies.h"
#include "denoise/stages/suppress_fireflies_shared.h"

namespace stillray::reference {
namespace {

/// Luminance of the brightest neighbour with samples; infinity if there is none.
float BrightestNeighbour(const LumaImage3& in, const Image1& samples, int x, int y) {
  float brightest = -1;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const int qx = x + dx;
      const int qy = y + dy;
      const bool inside = qx >= 0 && qy >= 0 && qx < in.width() && qy < in.height();
      if (inside && (dx != 0 || dy != 0) && samples(qx, qy) > 0) {
        brightest = std::max(brightest, in[0](qx, qy));
      }
    }
  }
  return brightest < 0 ? INFINITY : brightest;
}

void Scale(LumaImage3* colour, float (*scale)(float)) {
  for (int y = 0; y < colour->height(); ++y) {
    for (int x = 0; x < colour->width(); ++x) {
      const float s = scale((*colour)[0](x, y));
      for (int c = 0; c < 3; ++c) {
        (*colour)[c](x, y) *= s;
      }
    }
  }
}

}  // namespace

void ClampFireflies(const LumaImage3& in, const Image1& samples, Image1*, LumaImage3* out) {
  for (int y = 0; y < in.height(); ++y) {
    for (int x = 0; x < in.width(); ++x) {
      const float own = in[0](x, y);
      const float limit = BrightestNeighbour(in, samples, x, y);
      const float scale = ClampScale(own, limit);
      for (int c = 0; c < 3; ++c) {
        (*out)[c](x, y) = in[c](x, y) * scale;
      }
    }
  }
}

void CompressLight(LumaImage3* colour) {
  Scale(colour, CompressScale);
}

void ExpandLight(LumaImage3* colour) {
  Scale(colour, ExpandScale);
}

}  // namespace stillray::reference
