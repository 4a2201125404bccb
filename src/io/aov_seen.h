// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Whether a file has guides of what is seen in mirrors: layers for planar ones, and the shape of
/// convex ones.
#pragma once

#include <string>

#include "io/seen_guides.h"
#include "stillray/aov.h"

namespace stillray::io {

/// Imports guides alone.
/// \param layout        has kSeenDepth, kSeenNormal, kDepth, kNormal and kMotion
/// \param has_camera  whether the camera's motion is known by its matrices
NoSeenGuides CheckSeenLayers(const ExrImage& image, const AovLayout& layout, bool has_camera);

/// Likewise of hit distances, which need kDepth.
NoSeenGuides CheckHitLayers(const ExrImage& image, const AovLayout& layout, bool has_camera);

/// Decides whether the layers of what is seen are used, and drops them if not. They need everything
/// that they are compared with, and light of their own. Adds a note if the file has all of them.
void DecideSeenGuides(const ExrImage& image, AovLayout* layout);

/// The same of hit distances and of the motion of reflections. Those that are given and are not
/// used are dropped with a note that says why.
void DecideHits(const ExrImage& image, AovLayout* layout);

/// Replaces these notes for a sequence whose cameras are known.
/// \param image  the first file
void NoteSeenGuidesOfKnownCamera(const ExrImage& image, AovLayout* layout);

/// "reflections ... are blurred where they move: ...": the consequence, the layer that does not
/// fit, and the cure. Empty for kNone.
std::string LackOfImages(const AovLayout& layout, NoSeenGuides why);
/// Whether a note of the layout says so already, of the first frame.
bool IsNotedInLayout(const AovLayout& layout);

/// Imports guides alone. \param layout  has kDepth and kNormal
bool HasCurvedImages(const ExrImage& image, const AovLayout& layout);

/// Decides AovLayout::curved_images by the first frame: another renderer's file has reflected light
/// of its own, depth and normals, no images of its own, and convex surfaces. Adds a note.
void DecideCurvedImages(const ExrImage& image, AovLayout* layout);

}  // namespace stillray::io
