// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/accumulate.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/accumulate.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/join_history-inl.h"
#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

constexpr size_t kMostFetched = 80;

/// The inputs and outputs of the next row, except for the new samples.
NextRow<kMostFetched> NextRowOf(const Joining& j, const SignalHistory& out, int y) {
  NextRow<kMostFetched> next;
  const int width = j.light.samples.width();
  const auto add_history = [&](const SignalHistory& history, int row) {
    next.Add(history.colour, row);
    next.Add(history.behind, row);
    for (const Image1* plane : {&history.mean, &history.variance, &history.length,
                                &history.weights2, &history.compressed}) {
      next.Add(*plane, row);
    }
  };
  add_history(j.before, j.taps != nullptr ? RowOfTaps(*j.taps, width / 2, y) + 2 : y + 1);
  if constexpr (!kStreamsRows) {
    add_history(out, y + 1);
  }
  if (j.taps != nullptr) {
    AddTaps(*j.taps, y + 1, &next);
  }
  return next;
}

template <bool kLimited, bool kWithConfidence>
void AccumulateRow(const Joining& j, const LightRow& light, const NextRow<kMostFetched>& next,
                   bool sparse, int y, SignalHistory* out) {
  const DF d;
  const int width = j.light.samples.width();
  const SlotRows rows = RowsOf(out, y);
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    if (j.taps != nullptr) {
      FetchScattered(*j.taps, x, y);
    }
    const bool nothing_new = sparse && NoSamples(light.samples, x, width);
    JoinVector<kLimited, kWithConfidence>(
        j, light, nothing_new, x, y,
        [&](int slot, VF value) HWY_ATTR { StreamInRow(d, value, rows.row[slot], x, width); });
  }
}

using RowFunction = void (*)(const Joining&, const LightRow&, const NextRow<kMostFetched>&, bool,
                             int, SignalHistory*);

RowFunction RowFunctionOf(const Joining& j) {
  if (HasConfidence(j)) {
    return j.limits.bias != nullptr ? AccumulateRow<true, true> : AccumulateRow<false, true>;
  }
  return j.limits.bias != nullptr ? AccumulateRow<true, false> : AccumulateRow<false, false>;
}

void AccumulateRows(const Joining& j, int y0, int y1, SignalHistory* out) {
  const RowFunction accumulate_row = RowFunctionOf(j);
  for (int y = y0; y < y1; ++y) {
    const bool sparse = IsSparseRow(j.light.samples.Row(y), j.light.samples.width());
    NextRow<kMostFetched> next = NextRowOf(j, *out, y);
    if (!sparse) {
      next.Add(j.light.colour, y + 1);
    }
    next.Add(j.light.samples, y + 1);
    const LightRow light = LightRowOf(j.light, y);
    accumulate_row(j, light, next, sparse, y, out);
  }
  FinishStreams();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(AccumulateRows);

void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const HistoryLimits& limits, const AccumulateParameters& p, SignalHistory* out) {
  const Joining joining = {light, before, taps, limits, p, out->compressed_scale};
  ParallelRows(light.samples.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(AccumulateRows)(joining, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
