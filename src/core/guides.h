// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The albedo that divides each kind of light, and substitutes for guides that a frame lacks.
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

/// The albedo that light of this kind is divided by.
const Image3& AlbedoOf(const Guides& guides, SignalKind kind);

/// Whether the frame has light that is divided by this albedo.
bool DividesLight(const Frame& frame, const Image3& albedo);

/// Substitutes for missing guides: constant, so that they show no edge.
Image1 FlatDepth(int width, int height);   ///< one plane
Image3 FlatNormal(int width, int height);  ///< the same everywhere
Image3 WhiteAlbedo(int width, int height);

/// Whether a pixel of this depth shows a surface. False for NaN.
inline bool IsSurface(float depth) {
  return depth > 0 && std::isfinite(depth);
}

/// Motion that leads out of every picture of this size, so that there is no history.
inline vec2 UnknownMotion(int width, int height) {
  return {2.0f * static_cast<float>(width), 2.0f * static_cast<float>(height)};
}

/// Whether depth, normal and, with `demodulate`, every albedo that divides light are given.
bool HasGuides(const Frame& frame, bool demodulate);

/// Replaces missing images by the constant ones above. The sizes of the other images are not
/// checked.
void FillMissingGuides(bool demodulate, Frame* frame);

}  // namespace stillray
