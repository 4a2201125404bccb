// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// fxaa: smooths jagged edges within one frame. Source: PSVGF section 5 names FXAA (Lottes 2009),
/// while there are too few samples for temporal antialiasing. An edge is a step of the luminance;
/// the ends of the step are searched on both sides along it, and a pixel near an end is blended
/// with its neighbour across the edge, by the area that a slanted edge would cover. Departs: runs
/// on scene-linear radiance with contrast relative to the brighter side, so that the filter is
/// independent of exposure; at most kFxaaReach pixels are searched on each side. Border: kFxaaReach
/// + 1, repeated. Reads 16, writes 12 bytes per pixel.
#pragma once

#include "stillray/image.h"

namespace stillray {

/// \param length  history length in samples; the filter fades out from the first to the fourth.
///                nullptr: full strength everywhere
namespace reference {
void Fxaa(const Image3& colour, const Image1* length, Image3* out);
}
namespace cpu {
void Fxaa(const Image3& colour, const Image1* length, Image3* out);
}

}  // namespace stillray
