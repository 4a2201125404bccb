// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// tonemap: scene-linear light to 8-bit sRGB. Curves: tonemap_shared.h. Pixel by pixel.
/// Reads 12, writes 3 bytes per pixel.
#pragma once

#include <cstdint>

#include "denoise/stages/tonemap_shared.h"
#include "stillray/image.h"

namespace stillray {

/// Noise added before rounding, so that slow gradients show no bands.
struct Dither {
  float amount = 0;    ///< in steps of the result: triangular, +- this much
  uint32_t frame = 0;  ///< picks the noise
};

/// \param scale  2^exposure
/// \param curve  0 linear, 1 Reinhard, 2 filmic, 3 ACES
/// \param out    width * height * 3 bytes
namespace reference {
void Tonemap(const Image3& colour, float scale, int curve, const Dither& dither, uint8_t* out);
}
namespace cpu {
void Tonemap(const Image3& colour, float scale, int curve, const Dither& dither, uint8_t* out);
}

}  // namespace stillray
