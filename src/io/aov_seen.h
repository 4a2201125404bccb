// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Whether a file has guides of what is seen in mirrors: layers for planar ones, and the shape of
/// convex ones.
#pragma once

#include "io/seen_guides.h"
#include "stillray/aov.h"

namespace stillray::io {

/// Imports guides alone. \param layout  has kSeenDepth, kSeenNormal, kDepth, kNormal and kMotion
NoSeenGuides CheckSeenLayers(const ExrImage& image, const AovLayout& layout);

/// Decides whether the layers are used, and drops them if not. They need everything that they are
/// compared with, and light of their own. Adds a note if the file has all of them.
void DecideSeenGuides(const ExrImage& image, AovLayout* layout);

/// Imports guides alone. \param layout  has kDepth and kNormal
bool HasCurvedImages(const ExrImage& image, const AovLayout& layout);

/// Decides AovLayout::curved_images by the first frame: another renderer's file has reflected light
/// of its own, depth and normals, no images of its own, and convex surfaces. Adds a note.
void DecideCurvedImages(const ExrImage& image, AovLayout* layout);

}  // namespace stillray::io
