// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/picture_motion.h"

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
        const bool shows =
            ShowsLittleElse(surface.depth(x, y), selected.depth(x, y), selected.motion[0](x, y),
                            static_cast<float>(width), LuminanceAt(surface.albedo, 1.0f, x, y),
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
  ParallelRows(motion->height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < motion->width(); ++x) {
        if (images(x, y) != 0 && IsWithin(images, surface, x, y)) {
          (*motion)[0](x, y) = image_motion[0](x, y);
          (*motion)[1](x, y) = image_motion[1](x, y);
        }
      }
    }
  });
}

}  // namespace stillray
