// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/picture_motion.h"

#include <algorithm>

#include "core/colour.h"
#include "core/parallel.h"
#include "denoise/picture_motion_shared.h"

namespace stillray {
namespace {

/// \param absent  value if the image is empty
float LuminanceAt(const Image3& image, float absent, int x, int y) {
  return image.empty() ? absent
                       : Luminance709(vec3(image[0](x, y), image[1](x, y), image[2](x, y)));
}

/// Whether a pixel and those around it show images on one surface.
bool IsWithin(const Image1& images, const Guides& surface, int x, int y) {
  for (int v = y - kSilhouette; v <= y + kSilhouette; ++v) {
    for (int u = x - kSilhouette; u <= x + kSilhouette; ++u) {
      const bool inside = u >= 0 && v >= 0 && u < images.width() && v < images.height();
      if (!inside) {
        continue;
      }
      const bool same_id = surface.id.empty() || surface.id(u, v) == surface.id(x, y);
      if (images(u, v) == 0 || !same_id ||
          IsOtherSurface(surface.depth(x, y), surface.depth(u, v))) {
        return false;
      }
    }
  }
  return true;
}

/// The motion of the nearest image of the 3x3 neighbourhood that stands in front of the pixel's
/// own, of equal ones the first in reading order; as silhouettes of surfaces those of images move
/// with what is nearer. The pixel's own image has a motion, and the neighbours show images.
vec2 NearestImageMotion(const Image1& images, const Image2& motion, int x, int y) {
  const auto motion_at = [&](int u, int v) { return vec2(motion[0](u, v), motion[1](u, v)); };
  const auto width = static_cast<float>(images.width());
  const vec2 own = motion_at(x, y);
  const float depth = images(x, y);
  float nearest = depth;
  vec2 result = own;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, images.height() - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, images.width() - 1); ++u) {
      const float opposite = images(std::clamp(2 * x - u, 0, images.width() - 1),
                                    std::clamp(2 * y - v, 0, images.height() - 1));
      const vec2 candidate = motion_at(u, v);
      if (images(u, v) < nearest && StandsInFrontOfImage(depth, images(u, v), opposite) &&
          HasImageMotion(candidate.x, width) && MovesNearly(own, candidate)) {
        nearest = images(u, v);
        result = candidate;
      }
    }
  }
  return result;
}

}  // namespace

void FindImages(const Guides& surface, const Guides& selected, const Image3& albedo,
                const Image3& other, Image1* images) {
  const int width = surface.depth.width();
  if (images->width() != width || images->height() != surface.depth.height()) {
    *images = Image1(width, surface.depth.height());
  }
  if (selected.motion.empty()) {
    images->Fill(0);
    return;
  }
  ParallelRows(images->height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool shows = ShowsLittleElse(
            surface.depth(x, y), selected.depth(x, y), LuminanceAt(surface.albedo, 1.0f, x, y),
            LuminanceAt(albedo, 1.0f, x, y), LuminanceAt(other, 0.0f, x, y));
        (*images)(x, y) = ShownImage(selected.depth(x, y), shows);
      }
    }
  });
}

void FollowImages(const Image1& images, const Guides& surface, const Image2& image_motion,
                  Image2* motion) {
  if (motion->empty() || image_motion.empty()) {
    return;
  }
  const auto width = static_cast<float>(images.width());
  ParallelRows(motion->height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < motion->width(); ++x) {
        if (images(x, y) != 0 && HasImageMotion(image_motion[0](x, y), width) &&
            IsWithin(images, surface, x, y)) {
          const vec2 followed = NearestImageMotion(images, image_motion, x, y);
          (*motion)[0](x, y) = followed.x;
          (*motion)[1](x, y) = followed.y;
        }
      }
    }
  });
}

void TakeLengths(const Image1& images, const Image1& image_length, Image1* length) {
  ParallelRows(images.height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < images.width(); ++x) {
        (*length)(x, y) = images(x, y) != 0 ? image_length(x, y) : (*length)(x, y);
      }
    }
  });
}

}  // namespace stillray
