// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/colour_shared.h"
#include "denoise/stages/fxaa.h"
#include "denoise/stages/fxaa_pixel.h"

namespace stillray::reference {

void Fxaa(const Image3& colour, const Image1* length, Image3* out) {
  Image1 luma(colour.width(), colour.height());
  for (int y = 0; y < luma.height(); ++y) {
    for (int x = 0; x < luma.width(); ++x) {
      luma(x, y) = std::max(Luminance709(colour[0](x, y), colour[1](x, y), colour[2](x, y)), 0.0f);
    }
  }
  for (int y = 0; y < luma.height(); ++y) {
    for (int x = 0; x < luma.width(); ++x) {
      FxaaPixel(colour, luma, length, x, y, out);
    }
  }
}

}  // namespace stillray::reference
