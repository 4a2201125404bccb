// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/keep_samples.h"

#include <cmath>

namespace stillray::reference {

void MeasureSamples(const KeepSamplesInput& in, FilterPlanes* measured, Image1* valid) {
  const NewLight& light = *in.light;
  for (int y = 0; y < light.samples.height(); ++y) {
    for (int x = 0; x < light.samples.width(); ++x) {
      const float n = light.samples(x, y);
      const bool kept = KeepsSamples((*in.inverse_depth)(x, y), n);
      const float d = light.colour[0](x, y) - (*in.filtered)[0](x, y);
      (*valid)(x, y) = kept ? 1.0f : 0.0f;
      measured->colour[0](x, y) = kept ? d * d : 0.0f;
      measured->colour[1](x, y) =
          kept ? SampleNoise(light.within(x, y), (*in.variance)(x, y), n) : 0.0f;
      measured->variance(x, y) = 0;
    }
  }
}

void KeepSamples(const FilterPlanes& blurred, const Image1& valid, const NewLight& light,
                 float reach, LumaImage3* filtered) {
  for (int y = 0; y < valid.height(); ++y) {
    for (int x = 0; x < valid.width(); ++x) {
      const float deviation = std::abs(light.colour[0](x, y) - (*filtered)[0](x, y));
      const float share =
          valid(x, y) > 0
              ? ShareOfFiltered(blurred.colour[0](x, y), blurred.colour[1](x, y), deviation, reach)
              : 1.0f;
      for (int c = 0; c < 3 && share < 1; ++c) {
        const float kept = light.colour[c](x, y);
        (*filtered)[c](x, y) = kept + share * ((*filtered)[c](x, y) - kept);
      }
    }
  }
}

}  // namespace stillray::reference
