// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Which guide light is divided by, and what stands for guides that a frame does not have.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// The guide that light of this kind is divided by.
const Image3& AlbedoOf(const Guides& guides, SignalKind kind);

/// Whether the frame has light that is divided by this guide of its own.
bool DividesLight(const Frame& frame, const Image3& albedo);

// What a filter sees instead of a guide that is not given: no edge anywhere.
Image1 FlatDepth(int width, int height);   ///< one plane
Image3 FlatNormal(int width, int height);  ///< the same everywhere
Image3 WhiteAlbedo(int width, int height);

/// Whether depth, normal and, with `demodulate`, every albedo that divides light are given.
bool HasGuides(const Frame& frame, bool demodulate);

/// Puts the images above in place of those that are not given. Sizes of other images do not matter.
void FillMissingGuides(bool demodulate, Frame* frame);

}  // namespace stillray
