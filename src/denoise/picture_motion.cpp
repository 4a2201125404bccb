// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/picture_motion.h"

#include <cmath>
#include <cstdint>

#include "core/colour.h"
#include "core/parallel.h"

namespace stillray {
namespace {

/// The most diffuse light of a surface that shows an image, relative to the light of the image.
constexpr float kMostDiffuse = 0.1f;

float LuminanceAt(const Image3& image, int x, int y) {
  return image.empty() ? 1.0f : Luminance709(vec3(image[0](x, y), image[1](x, y), image[2](x, y)));
}

/// Antialiasing takes the motion of the nearest surface of 3x3 pixels, so that silhouettes stay
/// smooth. They move with the surface: pixels this near to them keep its motion.
constexpr int kSilhouette = 2;

/// Pixels that show little but an image, and whose image has a motion.
Plane<uint8_t> FindImages(const Guides& surface, const Guides& selected, const Image3& albedo) {
  const int width = surface.depth.width();
  Plane<uint8_t> images(width, surface.depth.height());
  const auto farthest = static_cast<float>(width);
  ParallelRows(images.height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool moves_within = std::abs(selected.motion[0](x, y)) < farthest;  // not NaN either
        images(x, y) = selected.depth(x, y) != surface.depth(x, y) && moves_within &&
                       LuminanceAt(surface.albedo, x, y) < kMostDiffuse * LuminanceAt(albedo, x, y);
      }
    }
  });
  return images;
}

/// Whether a pixel and those around it show images on one surface.
bool IsWithin(const Plane<uint8_t>& images, const Guides& surface, int x, int y) {
  constexpr float kSameDepth = 0.1f;
  for (int v = y - kSilhouette; v <= y + kSilhouette; ++v) {
    for (int u = x - kSilhouette; u <= x + kSilhouette; ++u) {
      const bool inside = u >= 0 && v >= 0 && u < images.width() && v < images.height();
      if (!inside) {
        continue;
      }
      const float z = surface.depth(x, y);
      const bool same_id = surface.id.empty() || surface.id(u, v) == surface.id(x, y);
      if (images(u, v) == 0 || !same_id || std::abs(surface.depth(u, v) - z) > kSameDepth * z) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

void FollowImages(const Guides& surface, const Guides& selected, const Image3& albedo,
                  Image2* motion) {
  if (motion->empty() || selected.motion.empty()) {
    return;
  }
  const Plane<uint8_t> images = FindImages(surface, selected, albedo);
  ParallelRows(motion->height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < motion->width(); ++x) {
        if (images(x, y) != 0 && IsWithin(images, surface, x, y)) {
          (*motion)[0](x, y) = selected.motion[0](x, y);
          (*motion)[1](x, y) = selected.motion[1](x, y);
        }
      }
    }
  });
}

}  // namespace stillray
