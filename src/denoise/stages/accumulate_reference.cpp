// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/shared.h"
#include "denoise/stages/accumulate.h"
#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/reproject.h"

namespace stillray::reference {
namespace {

/// \param taps  for the confidence in the history; may be nullptr
void Join(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
          const HistoryLimits& limits, const AccumulateParameters& p, SignalHistory* out) {
  for (int y = 0; y < light.samples.height(); ++y) {
    for (int x = 0; x < light.samples.width(); ++x) {
      const float n = light.samples(x, y);
      float length = before.length(x, y);
      if (limits.bias != nullptr) {
        length = LimitedLength(length, before.weights2(x, y), (*limits.bias)(x, y), limits.gain);
      }
      const float ratio = limits.ratio != nullptr ? (*limits.ratio)(x, y) : 1.0f;
      if (p.max_history > 0) {
        length = min(length, max(static_cast<float>(p.max_history) - n, 0.0f));
      }
      const float confidence = taps != nullptr ? taps->ConfidenceAt(x, y) : 1.0f;
      const bool constant = p.history_weight_constant != 0;
      const float alpha =
          NewFrameWeight(length, n, ConfidentAlpha(p.alpha_min, confidence), constant);
      const float alpha_moments =
          NewFrameWeight(length, n, ConfidentAlpha(p.alpha_moments, confidence), constant);
      const float l = light.colour[0](x, y);
      const float mean = before.mean(x, y) * ratio;
      const float d = l - mean;
      const float within = light.within.empty() ? 0.0f : light.within(x, y);
      for (int c = 0; c < 3; ++c) {
        const float old = before.colour[c](x, y) * ratio;
        out->colour[c](x, y) = old + alpha * (light.colour[c](x, y) - old);
        if (!before.behind.empty()) {
          const float behind = before.behind[c](x, y) * ratio;
          out->behind[c](x, y) = behind + alpha * (light.colour[c](x, y) - behind);
        }
      }
      if (out->compressed_scale > 0) {
        const float old = ScaledCompressed(before.compressed(x, y), ratio);
        out->compressed(x, y) = old + alpha * (CompressLuminance(l, out->compressed_scale) - old);
      }
      out->variance(x, y) =
          MixedVariance(before.variance(x, y) * ratio * ratio, d, within, alpha_moments);
      out->mean(x, y) = mean + alpha_moments * d;
      out->weights2(x, y) = MixedWeights2(before.weights2(x, y), n, alpha);
      out->length(x, y) = n > 0 ? length + n : before.length(x, y);
    }
  }
}

}  // namespace

void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const HistoryLimits& limits, const AccumulateParameters& p, SignalHistory* out) {
  if (taps == nullptr) {
    Join(light, before, nullptr, limits, p, out);
    return;
  }
  FetchHistory(before, *taps, out);
  Join(light, *out, taps, limits, p, out);
}

}  // namespace stillray::reference
