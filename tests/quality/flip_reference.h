// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// FLIP once more, straight from the equations of Andersson et al. 2020 and 2021: two-dimensional
/// kernels, double precision, nothing shared with the library. Slow.
#pragma once

#include <functional>
#include <vector>

#include "stillray/image.h"

namespace stillray::flip_reference {

/// Per-pixel LDR-FLIP, row by row, of two display pictures of linear RGB in 0..1.
std::vector<double> LdrFlip(const Image3& test, const Image3& reference);

/// The exposures of HDR-FLIP in stops, for a reference of which less than half is black.
std::vector<double> Exposures(const Image3& reference);

/// The picture that HDR-FLIP shows at an exposure.
Image3 Develop(const Image3& radiance, double stops);

/// Per-pixel HDR-FLIP.
std::vector<double> HdrFlip(const Image3& test, const Image3& reference);

double Mean(const std::vector<double>& values);

}  // namespace stillray::flip_reference
