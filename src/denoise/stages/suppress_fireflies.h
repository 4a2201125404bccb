// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// suppress_fireflies: optional limits for single samples that are far brighter than the rest.
/// Clamp: each pixel is scaled down to the luminance of the brightest of its eight neighbours.
/// Compress: c / (1 + luminance(c)), undone after filtering by ExpandLight; means taken under the
/// curve come out darker than true means, the more the noisier they are, and the curve is not
/// independent of exposure. Source: the Reinhard round trip of the CUDA EAW/SVGF reference.
/// No state. Border: 1 pixel. Reads and writes 12 bytes per pixel.
#pragma once

#include "denoise/planes.h"

namespace stillray {

/// \param work  room for ClampFireflies, made on first use
namespace reference {
void ClampFireflies(const Image3& in, const Image1& samples, Image1* work, Image3* out);
void CompressLight(Image3* colour);
void ExpandLight(Image3* colour);
}  // namespace reference
namespace cpu {
void ClampFireflies(const Image3& in, const Image1& samples, Image1* work, Image3* out);
void CompressLight(Image3* colour);
void ExpandLight(Image3* colour);
}  // namespace cpu

}  // namespace stillray
