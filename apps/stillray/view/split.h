// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Shows up to three images of one camera view side by side, separated by vertical dividers.
#pragma once

#include <vector>

#include "stillray/io.h"

namespace stillray::view {

/// The right ends of `count` panes, as increasing fractions of the width. `dividers` are the
/// dragged positions, which are clamped to the image and to a minimum distance.
std::vector<float> PaneEnds(const std::vector<float>& dividers, int count);

/// The window's content: a strip of each image, separated by light lines.
/// \param pictures  at least one image, all of equal size
Rgb8Image ComposePanes(const std::vector<Rgb8Image>& pictures, const std::vector<float>& dividers);

/// The image scaled up to a window of this size; unchanged if it is large enough.
/// \param sharp  enlarge without interpolation
Rgb8Image EnlargedTo(int width, int height, bool sharp, Rgb8Image picture);

}  // namespace stillray::view
