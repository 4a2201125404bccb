// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Whether a file has virtual guides: layers for planar mirrors, and the shape of convex ones.
#pragma once

#include <string>

#include "io/seen_guides.h"
#include "stillray/aov.h"

namespace stillray::io {

/// Imports guides alone.
/// \param layout        has kSeenDepth, kSeenNormal, kDepth, kNormal and kMotion
/// \param has_camera  whether the camera's motion is known by its matrices
NoSeenGuides CheckSeenLayers(const ExrImage& image, const AovLayout& layout, bool has_camera);

/// Imports guides and hit distances alone; needs kDepth.
NoSeenGuides CheckHitLayers(const ExrImage& image, const AovLayout& layout, bool has_camera);

/// Decides whether the kSeen layers are used, and drops them if not. They require the layers that
/// they are compared with, and separate specular or transmitted signals. Adds a note if the file
/// has all kSeen layers.
void DecideSeenGuides(const ExrImage& image, AovLayout* layout);

/// As above, for hit distances and the motion of reflections. Unused layers are dropped with a note
/// on the reason.
void DecideHits(const ExrImage& image, AovLayout* layout);

/// Replaces the notes above for a sequence with known cameras.
/// \param image  the first file
void NoteSeenGuidesOfKnownCamera(const ExrImage& image, AovLayout* layout);

/// "reflections ... are blurred where they move: ...": the consequence, the inconsistent layer, and
/// the remedy. Empty for kNone.
std::string LackOfImages(const AovLayout& layout, NoSeenGuides why);
/// Whether the layout already has this note, for the first frame.
bool IsNotedInLayout(const AovLayout& layout);

/// Imports guides alone. \param layout  has kDepth and kNormal
bool HasCurvedImages(const ExrImage& image, const AovLayout& layout);

/// Decides AovLayout::curved_images by the first frame: a file of another renderer with specular
/// signals, depth, normals and convex surfaces, but without virtual guides. Adds a note.
void DecideCurvedImages(const ExrImage& image, AovLayout* layout);

}  // namespace stillray::io
