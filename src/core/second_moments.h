// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Second moments of light that comes as means of several samples, without them.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Whether a pixel has more than one sample and a signal no second moments. Nothing is read but the
/// samples.
bool LacksSecondMoments(const Frame& frame);

/// Estimates the second moments that signals lack in frames with more than one sample in a pixel.
/// The variance v of a sample follows from the light of the pixels around, divided by its albedo.
/// A filter with the coefficients c_i removes whatever is linear; its result r at pixels of n_i
/// samples has the variance v sum(c_i^2 / n_i), so r^2 over that sum is an estimate of v:
///  - (1 -2 1) across and down (Immerkaer 1996, "Fast noise variance estimation", eq. 2), where the
///    3x3 pixels lie in one smooth surface: equal id, similar normals, inverse depth linear; for
///    specular and transmitted light also in the image that the surface shows (VirtualGuides)
///  - else the mean of (1 -2 1) in those of the four directions in which three pixels do.
///
/// v is the mean of the estimates in 3x3 pixels of the surface; where these have none that of 5x5
/// pixels of any surface, and where no guides are smooth, as under a lens, the mean of r^2 over
/// that of the sums in 5x5 pixels, whatever they show. Means hide the light of a rare bright sample
/// in the pixels around it: v is at least a share min(1, 4 / n) of what the pixel's own squared
/// difference from its neighbours on the surface estimates. A pixel of n samples then has the
/// second moment l^2 + v (n - 1) / n. Sets has_estimated_moments.
///
/// Missing pixels, and those without a surface, take no part; where nothing is left, v is 0.
/// \param frame  with samples, depth, and all albedos that divide light; normals, ids and virtual
///     guides may be empty
void EstimateSecondMoments(Frame* frame);

}  // namespace stillray
