// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// prepare_guides: converts the caller's guides to those of the filter. Source: SVGF section 4.4
/// and PSVGF section 4.4.2 need the slope of the depth, and compute it by screen-space derivatives.
/// Departs from them: the slope is that of inverse depth, which is constant over a plane, from
/// one-sided differences that do not cross edges. No state. Border: 1 pixel. Reads 24, writes 36
/// bytes per pixel, or 28 with packed normals: turns and gradients are then computed from the
/// rounded normals.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/reproject.h"

namespace stillray {

struct PrepareGuidesInput {
  const Image1* depth;
  const Image3* normal;
  const Plane<uint32_t>* id;  ///< nullptr: ids are unknown
};

/// \param out  sized width x height; its border is not written (zero); `turn2` may be empty
/// \return number of pixels whose depth is NaN or not positive, or whose normal is not finite,
///     which have no surface
namespace reference {
int64_t PrepareGuides(const PrepareGuidesInput& in, GuidePlanes* out);
}  // namespace reference
namespace cpu {
int64_t PrepareGuides(const PrepareGuidesInput& in, GuidePlanes* out);
}  // namespace cpu

}  // namespace stillray
