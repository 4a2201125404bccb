// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/shared.h"
#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/stages/prefilter_variance.h"

namespace stillray::reference {

void PrefilterVariance(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                       Image1* factor) {
  const Image1& variance = *in.variance;
  const Image1& valid = *in.valid;
  for (int y = 0; y < factor->height(); ++y) {
    for (int x = 0; x < factor->width(); ++x) {
      float sum = 0;
      float sum_weight = 0;
      const int radius = p.prefilter_variance != 0 ? 1 : 0;
      for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
          const float kernel = (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f);
          const float w = valid(x + dx, y + dy) > 0 ? kernel : 0.0f;
          sum += w * variance(x + dx, y + dy);
          sum_weight += w;
        }
      }
      const bool bounded = valid(x, y) > 0 && (*in.length)(x, y) >= p.short_history_blur;
      const float smoothed = sum / max(sum_weight, 1.0f);
      const float spread = p.luminance_scale_deviation != 0 ? sqrt(smoothed) : smoothed;
      (*factor)(x, y) =
          bounded ? LuminanceFactor((*in.luminance)(x, y), spread, p.sigma_l, p.luminance_epsilon)
                  : 0.0f;
    }
  }
}

}  // namespace stillray::reference
