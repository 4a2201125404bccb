// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The remainder: the colour minus the passes of light.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// Whether the passes hold so much light that the colour lacks that they cannot be its parts: the
/// colour was filtered, composited or graded after the passes were written. Its remainder would add
/// the noise of the passes back with the opposite sign. Light that only the colour has is no such
/// evidence.
/// \param layout  with passes of light and a colour
/// \param part    [out] fraction of the light of the passes that the colour lacks; pixels that are
///     not opaque, and sky, are left out
/// \return false also where too few pixels can be judged, or where the passes lack light
bool ColourIsOfOtherLight(const ExrImage& image, const AovLayout& layout, const std::string& name,
                          double* part);

}  // namespace stillray::io
