// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// suppress_fireflies: optional limits for single samples that are far brighter than their
/// neighbours. Clamp: each pixel is scaled down to the luminance of the brightest of its eight
/// neighbours. Compress: luminance above 32 is compressed to 64 at most, which ExpandLight undoes
/// after filtering. Source: the Reinhard round trip of the CUDA EAW/SVGF reference. Departs from
/// it: its curve, c / (1 + luminance), is nonlinear everywhere, so that means of compressed samples
/// are too dark, the more the noisier they are; here only samples above 32 lose energy. Neither
/// curve is independent of exposure. No state. Border: 1 pixel. Reads and writes 12 bytes per
/// pixel.
#pragma once

#include "denoise/planes.h"

namespace stillray {

/// \param work  work memory of ClampFireflies, allocated on first use
namespace reference {
void ClampFireflies(const LumaImage3& in, const Image1& samples, Image1* work, LumaImage3* out);
void CompressLight(LumaImage3* colour);
void ExpandLight(LumaImage3* colour);
}  // namespace reference
namespace cpu {
void ClampFireflies(const LumaImage3& in, const Image1& samples, Image1* work, LumaImage3* out);
void CompressLight(LumaImage3* colour);
void ExpandLight(LumaImage3* colour);
}  // namespace cpu

}  // namespace stillray
