// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "core/shared.h"
#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/stages/prefilter_variance.h"
#include "denoise/stages/reproject_shared.h"

namespace stillray::reference {
void PrefilterVariance(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                       Image1* factor) {
  const Image1& valid = *in.valid;
  const int radius = p.prefilter_variance != 0 ? 1 : 0;
  for (int y = 0; y < factor->height(); ++y) {
    for (int x = 0; x < factor->width(); ++x) {
      const bool bounded = valid(x, y) > 0 && (*in.length)(x, y) >= p.short_history_blur;
      const float smoothed = LimitedVariance(SmoothedVariance(*in.variance, valid, radius, x, y),
                                             (*in.variance)(x, y), p.prefilter_limit);
      const float given = in.confidence != nullptr ? (*in.confidence)(x, y) : 1.0f;
      const float sigma_l =
          p.sigma_l * VolumeWidening(UsedConfidence(given, std::isnan(given)), p.volume_widening);
      const float spread = p.luminance_scale_deviation != 0 ? sqrt(smoothed) : smoothed;
      (*factor)(x, y) = bounded ? LuminanceFactor((*in.luminance)(x, y), spread, sigma_l,
                                                  p.luminance_epsilon, p.luminance_floor)
                                : 0.0f;
    }
  }
}

void SmoothVariance(const SmoothVarianceInput& in, Image1* out) {
  for (int y = 0; y < out->height(); ++y) {
    for (int x = 0; x < out->width(); ++x) {
      (*out)(x, y) = (*in.valid)(x, y) > 0 ? SmoothedVariance(*in.variance, *in.valid, 1, x, y)
                                           : (*in.variance)(x, y);
    }
  }
}

}  // namespace stillray::reference
