// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Motion of pixels that show several surfaces.
#pragma once

#include <cstdint>

#include "stillray/image.h"

namespace stillray::io {

/// Marks motion as unknown at pixels where it is an average over surfaces that move differently: at
/// silhouettes of moving objects, due to the pixel filter or a lens. The average is the motion of
/// neither surface. Such a pixel agrees within half a pixel with fewer than three of its eight
/// neighbours; at a sharp silhouette pixels agree with more. The outermost pixels are unchanged.
/// \return the number of marked pixels
int64_t ForgetMixedMotion(Image2* motion);

}  // namespace stillray::io
