// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Whether a file's layers of what is seen in mirrors can be used.
#pragma once

#include "io/seen_guides.h"
#include "stillray/aov.h"

namespace stillray::io {

/// Imports guides alone. \param layout  has kSeenDepth, kSeenNormal, kDepth, kNormal and kMotion
NoSeenGuides CheckSeenLayers(const ExrImage& image, const AovLayout& layout);

/// Decides whether the layers are used, and drops them if not. They need everything that they are
/// compared with, and light of their own. Adds a note if the file has all of them.
void DecideSeenGuides(const ExrImage& image, AovLayout* layout);

}  // namespace stillray::io
