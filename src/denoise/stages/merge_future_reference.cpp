// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/merge_future.h"

#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/merge_future_shared.h"

namespace stillray::reference {

void MergeFuture(const SignalHistory& history, const SignalHistory& future, SignalHistory* out) {
  for (int y = 0; y < history.length.height(); ++y) {
    for (int x = 0; x < history.length.width(); ++x) {
      const float weights2 = history.weights2(x, y);
      const float future_weights2 = future.weights2(x, y);
      const float share =
          FutureShare(history.length(x, y), weights2, future.length(x, y), future_weights2);
      const float d = future.mean(x, y) - history.mean(x, y);
      for (int c = 0; c < 3; ++c) {
        const float past = history.colour[c](x, y);
        out->colour[c](x, y) = past + share * (future.colour[c](x, y) - past);
      }
      // A mixture of two sets of samples, as in accumulate.
      out->variance(x, y) = MixedVariance(history.variance(x, y), d, future.variance(x, y), share);
      out->mean(x, y) = history.mean(x, y) + share * d;
      out->length(x, y) = history.length(x, y) + future.length(x, y);
      out->weights2(x, y) = MergedWeights2(weights2, future_weights2, share);
    }
  }
}

}  // namespace stillray::reference
