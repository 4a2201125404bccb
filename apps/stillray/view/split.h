// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Shows up to three pictures of the same view side by side, separated by vertical dividers.
#pragma once

#include <vector>

#include "stillray/io.h"

namespace stillray::view {

/// The right ends of `count` panes, as increasing fractions of the width. `dividers` are those
/// between panes as dragged: kept apart and within the picture.
std::vector<float> PaneEnds(const std::vector<float>& dividers, int count);

/// The window's content: a strip of each picture, with light lines between.
/// \param pictures  of one size, at least one
Rgb8Image ComposePanes(const std::vector<Rgb8Image>& pictures, const std::vector<float>& dividers);

/// The picture enlarged as in a window of this size. A picture that is as large is unchanged.
/// \param sharp  enlarge without interpolation
Rgb8Image EnlargedTo(int width, int height, bool sharp, Rgb8Image picture);

}  // namespace stillray::view
