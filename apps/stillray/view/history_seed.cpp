// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/history_seed.h"

#include <algorithm>

#include "core/parallel.h"
#include "view/taps.h"

namespace stillray::view {
namespace {

float Sample(const Image1& plane, const Taps& x, const Taps& y) {
  const auto row = [&](int v) { return Mixed(plane(x.first, v), plane(x.second, v), x.weight); };
  return Mixed(row(y.first), row(y.second), y.weight);
}

float ValueAt(const Image3& image, int c, int x, int y) {
  return image[c].empty() ? 0.0f : image[c](x, y);
}

}  // namespace

Frame SeedFrame(const Frame& guides, const Image3& picture, float samples, bool keeps_guides) {
  Frame seed;
  seed.width = guides.width;
  seed.height = guides.height;
  seed.index = guides.index;
  seed.jitter_x = guides.jitter_x;
  seed.jitter_y = guides.jitter_y;
  seed.guides = guides.guides;
  seed.emission = guides.emission;
  seed.background = guides.background;
  seed.samples = Image1(seed.width, seed.height);
  seed.signals.resize(1);
  Image3& light = seed.signals[0].radiance;
  light = Image3(seed.width, seed.height);
  // The filter keeps the guides of a frame for later frames only if the frame has missing guides:
  // one corner pixel, which is filled from its neighbours, is marked missing.
  if (keeps_guides) {
    seed.guides.depth(0, 0) = 0;
  }
  // Zero motion: the image equals its previous frame.
  seed.guides.motion = Image2(seed.width, seed.height);
  ParallelRows(seed.height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const Taps from_y = TapsAt(y, seed.height, picture.height());
      for (int x = 0; x < seed.width; ++x) {
        const Taps from_x = TapsAt(x, seed.width, picture.width());
        seed.samples(x, y) = keeps_guides && x == 0 && y == 0 ? 0.0f : samples;
        for (int c = 0; c < 3; ++c) {
          const float other = ValueAt(seed.emission, c, x, y) + ValueAt(seed.background, c, x, y);
          light[c](x, y) = std::max(Sample(picture[c], from_x, from_y) - other, 0.0f);
        }
      }
    }
  });
  return seed;
}

}  // namespace stillray::view
