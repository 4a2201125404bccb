// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/fxaa.h"

#include <algorithm>
#include <atomic>
#include <cstring>

#include "core/colour_shared.h"
#include "core/parallel.h"
#include "denoise/stages/fxaa_pixel.h"

namespace stillray::cpu {
namespace {

void CopyRow(const Image3& from, int y, Image3* to) {
  for (int c = 0; c < 3; ++c) {
    std::memcpy((*to)[c].Row(y), from[c].Row(y), static_cast<size_t>(from.width()) * sizeof(float));
  }
}

/// Whether any pixel of the rows is young enough for the filter to do anything.
bool AnyYoung(const Image1* length, int y0, int y1) {
  if (length == nullptr) {
    return true;
  }
  for (int y = y0; y < y1; ++y) {
    const float* row = length->Row(y);
    bool young = false;
    for (int x = 0; x < length->width(); ++x) {
      young |= FxaaStrength(row[x]) > 0;
    }
    if (young) {
      return true;
    }
  }
  return false;
}

}  // namespace

void Fxaa(const Image3& colour, const FxaaParameters& p, Image3* out) {
  constexpr int kBand = 16;
  const int width = colour.width();
  const int height = colour.height();
  std::atomic<bool> young = false;
  ParallelRows(height, kBand, [&](int y0, int y1) {
    if (AnyYoung(p.length, y0, y1)) {
      young = true;
    }
  });
  Image1 luma;
  if (young) {
    luma = Image1(width, height);
    ParallelRows(height, kBand, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        const float* r = colour[0].Row(y);
        const float* g = colour[1].Row(y);
        const float* b = colour[2].Row(y);
        float* to = luma.Row(y);
        for (int x = 0; x < width; ++x) {
          to[x] = std::max(Luminance709(r[x], g[x], b[x]), 0.0f);
        }
      }
    });
  }
  ParallelRows(height, kBand, [&](int y0, int y1) {
    const bool any = young && AnyYoung(p.length, y0, y1);
    for (int y = y0; y < y1; ++y) {
      if (!any) {
        CopyRow(colour, y, out);
        continue;
      }
      for (int x = 0; x < width; ++x) {
        FxaaPixel(colour, luma, p.length, x, y, out);
      }
    }
  });
}

}  // namespace stillray::cpu
