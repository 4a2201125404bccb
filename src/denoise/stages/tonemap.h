// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// tonemap: converts scene-linear radiance to 8-bit sRGB. Curves: tonemap_shared.h. Pixel by pixel.
/// Reads 12, writes 3 bytes per pixel.
#pragma once

#include <cstdint>

#include "denoise/stages/tonemap_shared.h"
#include "stillray/image.h"

namespace stillray {

/// \param out  width * height * 3 bytes
namespace reference {
void Tonemap(const Image3& colour, const TonemapParameters& parameters, uint8_t* out);
}
namespace cpu {
void Tonemap(const Image3& colour, const TonemapParameters& parameters, uint8_t* out);
}

}  // namespace stillray
