// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Estimates second moments of radiance that is a mean over several samples.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Whether any pixel has more than one sample and any signal has no second moments. Only the plane
/// of samples is read.
bool LacksSecondMoments(const Frame& frame);

/// Estimates missing second moments in frames with more than one sample per pixel. The variance v
/// of a sample is estimated from the demodulated radiance of neighbouring pixels. A filter with the
/// coefficients c_i removes linear variation; its result r at pixels of n_i samples has the
/// variance v sum(c_i^2 / n_i), so r^2 over that sum is an estimate of v:
///  - (1 -2 1) across and down (Immerkaer 1996, "Fast noise variance estimation", eq. 2), where the
///    3x3 pixels lie in one smooth surface: equal id, similar normals, inverse depth linear; for
///    specular and transmitted light also in the virtual image (VirtualGuides)
///  - else the mean of (1 -2 1) over the four directions, without those that leave the surface.
///
/// v is the mean of the estimates in 3x3 pixels of the surface; if there are none, in 5x5 pixels of
/// any surface; and if no guides are smooth, as under a lens, the mean of r^2 over the mean of the
/// sums in 5x5 pixels. A mean underestimates the variance at rare bright samples: v is at least
/// min(1, 4 / n) times the estimate from the pixel's own squared difference to its neighbours on
/// the surface. A pixel of n samples then has the second moment l^2 + v (n - 1) / n. Sets
/// has_estimated_moments.
///
/// Missing pixels and pixels without a surface are ignored; without usable pixels v is 0.
/// \param frame  with samples, depth, and all albedos that divide light; normals, ids and virtual
///     guides may be empty
void EstimateSecondMoments(Frame* frame);

}  // namespace stillray
