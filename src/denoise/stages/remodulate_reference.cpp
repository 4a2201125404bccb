// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/colour_shared.h"
#include "denoise/stages/remodulate.h"

namespace stillray::reference {

void Remodulate(const Image3& light, const Image3* albedo_a, const Image3* albedo_b, Image3* sum) {
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < sum->height(); ++y) {
      for (int x = 0; x < sum->width(); ++x) {
        const float a = albedo_a != nullptr ? (*albedo_a)[c](x, y) : 0.0f;
        const float b = albedo_b != nullptr ? (*albedo_b)[c](x, y) : 0.0f;
        const bool multiply = albedo_a != nullptr || albedo_b != nullptr;
        (*sum)[c](x, y) += multiply ? stillray::Remodulate(light[c](x, y), a + b) : light[c](x, y);
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
