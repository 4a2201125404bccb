// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The remainder: the colour minus the passes of light.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// Whether the passes exceed the colour so much that they are not its summands: the colour was
/// filtered, composited or graded after the passes were written. Its remainder would contain the
/// noise of the passes with the opposite sign. Radiance missing in the passes does not count.
/// \param layout  with passes of light and a colour
/// \param part    [out] fraction of the passes' radiance that is missing in the colour; transparent
///     pixels and sky are excluded
/// \return false also if too few pixels are usable, or if radiance is missing in the passes
bool ColourIsOfOtherLight(const ExrImage& image, const AovLayout& layout, const std::string& name,
                          double* part);

}  // namespace stillray::io
