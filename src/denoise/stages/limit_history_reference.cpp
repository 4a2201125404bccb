// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/colour_shared.h"
#include "denoise/stages/limit_history.h"
#include "denoise/stages/limit_history_shared.h"

namespace stillray::reference {
namespace {

float Luminance(const Image3& c, int x, int y, bool rec601) {
  return (rec601 ? Luminance601 : Luminance709)(c[0](x, y), c[1](x, y), c[2](x, y));
}

/// Variance of this frame's value of a pixel, compressed.
float FrameNoise(const NewLight& light, const SignalHistory& before, float mean, int x, int y) {
  return CompressVariance(before.mean(x, y), before.variance(x, y), mean) /
         max(light.samples(x, y), 1.0f);
}

}  // namespace

void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const GuidePlanes& guides, const LimitHistoryParameters& p,
                        FilterPlanes* compared, Image1* present) {
  for (int y = 0; y < light.samples.height(); ++y) {
    for (int x = 0; x < light.samples.width(); ++x) {
      const bool both =
          guides.inverse_depth(x, y) > 0 && light.samples(x, y) > 0 && before.length(x, y) > 0;
      const float noise = FrameNoise(light, before, p.mean, x, y);
      const float history_noise = CompressVariance(
          before.mean(x, y), before.variance(x, y) * before.weights2(x, y), p.mean);
      (*present)(x, y) = both ? 1.0f : 0.0f;
      compared->colour[0](x, y) =
          both ? CompressLuminance(Luminance(light.colour, x, y, p.rec601), p.mean) : 0.0f;
      compared->colour[1](x, y) =
          both ? CompressLuminance(Luminance(before.colour, x, y, p.rec601), p.mean) : 0.0f;
      compared->colour[2](x, y) = 0;
      compared->variance(x, y) = both ? noise + history_noise : 0.0f;
    }
  }
}

void LimitHistory(const FilterPlanes& blurred, const Image1& present, const NewLight& light,
                  const SignalHistory& before, const LimitHistoryParameters& p, Image1* limit) {
  for (int y = 0; y < limit->height(); ++y) {
    for (int x = 0; x < limit->width(); ++x) {
      const float length = before.length(x, y);
      const float d = blurred.colour[0](x, y) - blurred.colour[1](x, y);
      const float limited = LimitedLength(length, before.weights2(x, y), d, blurred.variance(x, y),
                                          FrameNoise(light, before, p.mean, x, y), p.dead, p.gain);
      (*limit)(x, y) = present(x, y) > 0 ? limited : length;
    }
  }
}

}  // namespace stillray::reference
