// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/colour_shared.h"
#include "denoise/stages/remodulate.h"

namespace stillray::reference {

void Remodulate(const Image3& light, const AlbedoSum& albedo, const RemodulateParameters& p,
                Image3* sum) {
  for (int y = 0; y < sum->height(); ++y) {
    for (int x = 0; x < sum->width(); ++x) {
      const float r = light[1](x, y);
      const float b = light[2](x, y);
      const float rgb[3] = {
          r, p.rec601 ? Green601(light[0](x, y), r, b) : Green709(light[0](x, y), r, b), b};
      for (int c = 0; c < 3; ++c) {
        float factor = 0;
        for (int i = 0; i < albedo.count; ++i) {
          factor += (*albedo.part[i])[c](x, y);
        }
        const float radiance = albedo.count > 0 ? stillray::Remodulate(rgb[c], factor) : rgb[c];
        (*sum)[c](x, y) = radiance + (p.add ? (*sum)[c](x, y) : 0.0f);
      }
    }
  }
}

int64_t AddUnfiltered(const Image3& light, Image3* sum) {
  int64_t bad = 0;
  for (int y = 0; y < sum->height(); ++y) {
    for (int x = 0; x < sum->width(); ++x) {
      const bool finite = std::isfinite(light[0](x, y)) && std::isfinite(light[1](x, y)) &&
                          std::isfinite(light[2](x, y));
      for (int c = 0; c < 3; ++c) {
        (*sum)[c](x, y) += finite ? light[c](x, y) : 0.0f;
      }
      bad += finite ? 0 : 1;
    }
  }
  return bad;
}

}  // namespace stillray::reference
