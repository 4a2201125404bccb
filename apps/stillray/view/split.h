// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Up to three pictures of one place side by side, cut at upright dividers.
#pragma once

#include <vector>

#include "stillray/io.h"

namespace stillray::view {

/// Where each of `count` panes ends, as fractions of the width, rising. `dividers` are those
/// between panes as dragged: kept apart and within the picture.
std::vector<float> PaneEnds(const std::vector<float>& dividers, int count);

/// What the window shows: of each picture its strip, with light lines between.
/// \param pictures  of one size, at least one
Rgb8Image ComposePanes(const std::vector<Rgb8Image>& pictures, const std::vector<float>& dividers);

/// The picture as a window of this size shows it. A picture that is as large stays as it is.
/// \param sharp  enlarge without interpolation
Rgb8Image EnlargedTo(int width, int height, bool sharp, Rgb8Image picture);

}  // namespace stillray::view
