// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/one_signal.h"

#include <algorithm>

#include "core/parallel.h"

namespace stillray {
namespace {

/// The sum of images, of which some may be empty.
void Sum(const std::vector<const Image3*>& parts, int width, int height, Image3* out) {
  if (out->width() != width || out->height() != height) {
    *out = Image3(width, height);
  }
  ParallelRows(height, 32, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c) {
      for (int y = y0; y < y1; ++y) {
        float* to = (*out)[c].Row(y);
        std::fill_n(to, width, 0.0f);
        for (const Image3* part : parts) {
          const float* from = part->empty() ? nullptr : (*part)[c].Row(y);
          for (int x = 0; x < width && from != nullptr; ++x) {
            to[x] += from[x];
          }
        }
      }
    }
  });
}

}  // namespace

void ToOneSignal(const Frame& frame, Frame* out) {
  const bool has_moments =
      std::any_of(frame.signals.begin(), frame.signals.end(),
                  [](const Signal& signal) { return !signal.second_moment.empty(); });
  if (has_moments) {
    *out = frame;
    return;
  }
  std::vector<const Image3*> light;
  for (const Signal& signal : frame.signals) {
    light.push_back(&signal.radiance);
  }
  out->width = frame.width;
  out->height = frame.height;
  out->index = frame.index;
  out->jitter_x = frame.jitter_x;
  out->jitter_y = frame.jitter_y;
  out->focal_pixels = frame.focal_pixels;
  out->signals.resize(1);
  out->signals[0].kind = SignalKind::kDirectDiffuse;
  Sum(light, frame.width, frame.height, &out->signals[0].radiance);
  const Guides& g = frame.guides;
  Sum({&g.albedo, &g.specular_albedo, &g.transmission_albedo}, frame.width, frame.height,
      &out->guides.albedo);
  out->guides.depth = g.depth;
  out->guides.normal = g.normal;
  out->guides.motion = g.motion;
  out->guides.id = g.id;
  out->emission = frame.emission;
  out->background = frame.background;
  out->samples = frame.samples;
}

}  // namespace stillray
