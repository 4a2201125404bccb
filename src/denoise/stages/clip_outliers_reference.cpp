// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/clip_outliers.h"

namespace stillray::reference {
namespace {

/// Statistics of the neighbours with samples.
struct Neighbours {
  int count = 0;
  float lowest = 1e37f;
  float highest = -1e37f;
  float sum[3] = {};
};

Neighbours NeighboursOf(const LumaImage3& light, const Image1& where, int x, int y) {
  Neighbours n;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if ((dx != 0 || dy != 0) && where(x + dx, y + dy) > 0) {
        n.count += 1;
        n.lowest = min(n.lowest, light[0](x + dx, y + dy));
        n.highest = max(n.highest, light[0](x + dx, y + dy));
        for (int c = 0; c < 3; ++c) {
          n.sum[c] += light[c](x + dx, y + dy);
        }
      }
    }
  }
  return n;
}

}  // namespace

void ClipOutliers(const ClipOutliersInput& in, const ClipOutliersParameters& p,
                  FilterPlanes* scratch, LumaImage3* light) {
  for (int y = 0; y < light->height(); ++y) {
    for (int x = 0; x < light->width(); ++x) {
      const float l = (*light)[0](x, y);
      const Neighbours n = NeighboursOf(*light, *in.where, x, y);
      const bool clips = (*in.where)(x, y) > 0 && n.count > 0 &&
                         IsOutlier(l, n.lowest, n.highest, (*in.variance)(x, y), p.clip_outliers);
      for (int c = 0; c < 3; ++c) {
        const float mean = clips ? n.sum[c] / static_cast<float>(n.count) : 0.0f;
        const float mean_luminance = n.sum[0] / static_cast<float>(max(n.count, 1));
        scratch->colour[c](x, y) =
            clips ? mean * ClippedScale(l, n.lowest, n.highest, mean_luminance) : (*light)[c](x, y);
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < light->height(); ++y) {
      for (int x = 0; x < light->width(); ++x) {
        (*light)[c](x, y) = scratch->colour[c](x, y);
      }
    }
  }
}

}  // namespace stillray::reference
