// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// spline_coefficients: the coefficients of the cubic B-spline that passes through the pixels of an
/// image, for antialias. Source: Unser, Aldroubi, Eden 1993 ("B-Spline Signal Processing"), section
/// III, with the recursive filter's response cut off at 4 pixels: the spline then passes within 0.1
/// % of an isolated pixel. Edge pixels are repeated. Border: 4 pixels. Reads 12, writes 12 bytes
/// per pixel.
#pragma once

#include "denoise/planes.h"

namespace stillray {

namespace reference {
/// \param out  size of \p picture
void SplineCoefficients(const Image3& picture, Image3* out);
}  // namespace reference
namespace cpu {
void SplineCoefficients(const Image3& picture, Image3* out);
}  // namespace cpu

}  // namespace stillray
