// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Second moments of light that comes as means of several samples, without them.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Estimates the second moments that signals lack in frames with more than one sample in a pixel.
/// The variance of a sample follows from the pixels around: light l divided by its albedo is
/// filtered with (1 -2 1) across and down, which removes whatever is linear over 3x3 pixels
/// (Immerkaer 1996, "Fast noise variance estimation", eq. 2). If a sample has the variance v there,
/// and pixel i has n_i samples and the coefficient c_i, the result r has the variance
/// v sum(c_i^2 / n_i): v is the mean of r^2 over that of the sums, over 5x5 such results. A pixel
/// of n samples then has the second moment l^2 + v (n - 1) / n.
///
/// Missing pixels, and those without a surface, take no part. Where all results miss one, v is 0.
/// \param frame  with samples and all albedos that divide light
void EstimateSecondMoments(Frame* frame);

}  // namespace stillray
