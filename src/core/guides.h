// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The albedo of each kind of signal, and substitutes for missing guides.
#pragma once

#include <array>
#include <cmath>

#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray {

/// Diffuse, specular and transmission albedo.
inline std::array<const Image3*, 3> AlbedosOf(const Guides& g) {
  return {&g.albedo, &g.specular_albedo, &g.transmission_albedo};
}

/// The albedo that divides signals of this kind.
const Image3& AlbedoOf(const Guides& guides, SignalKind kind);

/// Whether the frame has a signal that is divided by this albedo.
bool DividesLight(const Frame& frame, const Image3& albedo);

/// Substitutes for missing guides: constant, so that they have no edges.
Image1 FlatDepth(int width, int height);   ///< one plane
Image3 FlatNormal(int width, int height);  ///< the same everywhere
Image3 WhiteAlbedo(int width, int height);

/// Whether a pixel of this depth is on a surface. False for NaN.
inline bool IsSurface(float depth) {
  return depth > 0 && std::isfinite(depth);
}

/// Motion that points outside any image of this size, so that there is no history.
inline vec2 UnknownMotion(int width, int height) {
  return {2.0f * static_cast<float>(width), 2.0f * static_cast<float>(height)};
}

/// Whether depth, normal and, with `demodulate`, every albedo that divides light are given.
bool HasGuides(const Frame& frame, bool demodulate);

/// Replaces missing images by the constant images above. The sizes of the other images are not
/// checked.
void FillMissingGuides(bool demodulate, Frame* frame);

}  // namespace stillray
