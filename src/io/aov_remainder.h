// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What is left of the colour when the passes of light are taken off.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// Whether the passes hold so much that the colour does not have that they are not the same light:
/// the colour was filtered, composited or graded after the passes were written. Its remainder would
/// put the noise of the passes back, with the opposite sign. Light that only the colour has is no
/// such sign.
/// \param layout  with passes of light and a colour
/// \param part    [out] of the light of the passes that the colour lacks; pixels that are not
///        opaque, and sky, are not judged
/// \return false also where too little can be judged, or where the passes lack light
bool ColourIsOfOtherLight(const ExrImage& image, const AovLayout& layout, const std::string& name,
                          double* part);

}  // namespace stillray::io
