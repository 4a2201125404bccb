// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/shared.h"
#include "denoise/stages/limit_history.h"
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/reproject.h"

namespace stillray::reference {
namespace {

SignalHistory Fetched(const SignalHistory& before, const ReprojectionTaps& taps) {
  SignalHistory fetched = before;
  FetchHistory(before, taps, &fetched);
  return fetched;
}

}  // namespace

void CompareWithHistory(const NewLight& light, const SignalHistory& history,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        FilterPlanes* compared, Image1* valid) {
  const SignalHistory before = Fetched(history, taps);
  for (int y = 0; y < light.samples.height(); ++y) {
    for (int x = 0; x < light.samples.width(); ++x) {
      const float n = light.samples(x, y);
      const bool both = guides.inverse_depth(x, y) > 0 && n > 0 && before.length(x, y) > 0;
      const float now = CompressLuminance(light.colour[0](x, y), before.compressed_scale);
      const float then = before.compressed(x, y);
      const float single = CompressedVariance(then, before.mean(x, y), before.variance(x, y),
                                              before.compressed_scale);
      const float noise = single * (1.0f / max(n, 1.0f) + before.weights2(x, y));
      (*valid)(x, y) = both ? 1.0f : 0.0f;
      if (both) {
        compared->colour[0](x, y) = now - then;
        compared->colour[1](x, y) = single;
        compared->variance(x, y) = noise;
      }
    }
  }
}

void LimitHistory(const FilterPlanes& blurred, const Image1& valid, const SignalHistory& history,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& p, Image1* limit) {
  const SignalHistory before = Fetched(history, taps);
  for (int y = 0; y < limit->height(); ++y) {
    for (int x = 0; x < limit->width(); ++x) {
      const float length = before.length(x, y);
      const float limited = LimitedLength(length, before.weights2(x, y), blurred.colour[0](x, y),
                                          blurred.variance(x, y), blurred.colour[1](x, y),
                                          p.limit_dead, p.limit_gain);
      (*limit)(x, y) = valid(x, y) > 0 ? limited : length;
    }
  }
}

}  // namespace stillray::reference
