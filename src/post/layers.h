// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Depth order for gathering effects: each pixel spreads its radiance evenly over its own blur (a
/// disc, or the path of a point), and the result is composited from three layers of neighbours: in
/// front of the pixel, on its surface, and behind it.
///
/// The coverages of the layers are added from the front until the pixel is full, so that parts of
/// one surface with slightly different depths cover it exactly once. The background hidden by a
/// blurred edge is not in the image: it is reconstructed from neighbours behind, within the blur of
/// the edge.
#pragma once

#include <algorithm>

namespace stillray::post {

inline float Clamp01(float x) {
  return std::min(std::max(x, 0.0f), 1.0f);
}

/// The radius of a sharp pixel: its radiance stays in the pixel.
inline constexpr float kSharpRadius = 0.5f;

/// The coverage of a pixel by a blur of this radius at a distance, with an edge one pixel wide.
inline float Coverage(float radius, float distance) {
  return Clamp01(radius + 0.5f - distance);
}

/// The layers of a tap; the three weights sum to 1.
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

/// Sums over the taps of a pixel: weights, and weighted radiance.
struct Layer {
  float weight = 0;
  float light[3] = {0, 0, 0};
};

struct LayerSums {
  Layer front;
  Layer beside;
  Layer behind;
  /// The fraction of the pixel's own blur occluded by pixels that do not spread over it: the
  /// radiance of the surface there is unknown.
  float hidden = 0;
};

/// The coverages of the three layers in the pixel: they sum to 1.
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
