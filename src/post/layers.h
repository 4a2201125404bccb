// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What lies before what, for effects that gather: each pixel spreads its light evenly over its own
/// blur (a disc, or the path of a point), and a picture's pixel is put together of three layers of
/// its neighbours, those in front of it, those beside it, and those behind.
///
/// The shares of a pixel that the layers cover add up, from the front, until the pixel is full:
/// pieces of one surface, of which some are a little nearer than others, then cover it exactly
/// once. What is hidden behind a blurred edge is not in the picture: it is made of the neighbours
/// that lie behind, as far away as the edge is blurred.
#pragma once

#include <algorithm>

namespace stillray::post {

inline float Clamp01(float x) {
  return std::min(std::max(x, 0.0f), 1.0f);
}

/// The radius of a sharp pixel: its light stays in its own pixel.
inline constexpr float kSharpRadius = 0.5f;

/// The part of a pixel that a blur of this radius covers at a distance, with an edge one pixel
/// wide.
inline float Coverage(float radius, float distance) {
  return Clamp01(radius + 0.5f - distance);
}

/// To which layer a tap belongs; the three shares add up to 1.
struct Sides {
  float front;
  float beside;
  float behind;
};

/// \param order  > 0: the tap lies behind the pixel; -1 to 1: both belong to one surface
inline Sides SidesOf(float order) {
  const float front = Clamp01(-order - 1.0f);
  const float behind = Clamp01(order - 1.0f);
  return {front, 1.0f - front - behind, behind};
}

/// Sums over the taps of a pixel: weights, and weighted light.
struct Layer {
  float weight = 0;
  float light[3] = {0, 0, 0};
};

struct LayerSums {
  Layer front;
  Layer beside;
  Layer behind;
  /// The part of the pixel's own blur that others hide which do not spread over the pixel: the
  /// light of its surface there is unknown.
  float hidden = 0;
};

/// The shares of the three layers in the pixel: they add up to 1.
/// \param sums  the pixel itself is among the taps of `beside`
inline Sides Shares(const LayerSums& sums) {
  const float front = std::min(sums.front.weight, 1.0f);
  const float open = 1.0f - front;
  const float own = sums.beside.weight / std::max(1.0f - sums.hidden, sums.beside.weight);
  const float beside = std::min(own, open);
  return sums.behind.weight > 0.0f ? Sides{front, beside, open - beside} : Sides{front, open, 0.0f};
}

/// One channel of the pixel.
inline float Compose(const LayerSums& sums, const Sides& shares, int channel) {
  const auto part = [channel](const Layer& layer, float share) {
    return share > 0.0f ? share * (layer.light[channel] / layer.weight) : 0.0f;
  };
  return part(sums.front, shares.front) + part(sums.beside, shares.beside) +
         part(sums.behind, shares.behind);
}

}  // namespace stillray::post
