// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/fused/fused.h"

#include "core/parallel.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/cpu/fused/accumulate_in_place.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/join_history-inl.h"
#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Accumulates the new samples of the pixels x, x + 1, ... of row y into their history. Not inline:
/// inlining it into both loops below would take two minutes to compile.
/// \param slots  receives a vector for each slot of the history
template <bool kLimited, bool kWithConfidence>
HWY_NOINLINE void JoinToSlots(const Joining& j, int x, int y, float* slots) {
  JoinVector<kLimited, kWithConfidence>(
      j, LightRowOf(j.light, y), false, x, y,
      [&](int slot, VF value) HWY_ATTR { hn::StoreU(value, DF(), slots + slot * LaneCount()); });
}

using JoinFunction = void (*)(const Joining&, int, int, float*);

JoinFunction JoinFunctionOf(const Joining& j) {
  if (HasConfidence(j)) {
    return j.limits.bias != nullptr ? JoinToSlots<true, true> : JoinToSlots<false, true>;
  }
  return j.limits.bias != nullptr ? JoinToSlots<true, false> : JoinToSlots<false, false>;
}

/// Stores the output of JoinToSlots in the planes of the history.
HWY_INLINE void StoreSlots(const Joining& j, const float* slots, const SlotRows& rows, int x,
                           int width) {
  const DF d;
  for (int slot = 0; slot < kHistorySlots; ++slot) {
    if (rows.row[slot] != nullptr && (slot != kCompressedSlot || j.compressed_scale > 0)) {
      StoreInRow(d, hn::LoadU(d, slots + slot * LaneCount()), rows.row[slot], x, width);
    }
  }
}

/// Computes the vectors whose taps are other pixels, before any pixel is overwritten.
void StageRows(const Joining& j, int y0, int y1, StagedHistory* staged) {
  const int width = j.light.samples.width();
  const JoinFunction join = JoinFunctionOf(j);
  for (int y = y0; y < y1; ++y) {
    float* to = staged->Row(y, LaneCount());
    for (int x = 0; x < width && j.taps->gathers[static_cast<size_t>(y)] > 0; x += LaneCount()) {
      if (IsGather(j.taps->Pattern(x / LaneCount(), y))) {
        join(j, x, y, to);
        to += kHistorySlots * LaneCount();
      }
    }
  }
}

/// Whether all of the pixels x, x + 1, ..., or none of them, have samples so far.
HWY_INLINE bool AllAre(bool lit, const SignalHistory& history, int x, int y) {
  const DF d;
  const MF some = hn::Gt(hn::LoadU(d, history.length.Row(y) + x), hn::Zero(d));
  const MF in_row = InRow(x, history.length.width());
  return lit ? hn::AllTrue(d, hn::Or(some, hn::Not(in_row)))
             : hn::AllFalse(d, hn::And(some, in_row));
}

/// Whether the history of the pixels x, x + 1, ... is unchanged without new samples, if no
/// confidence shortens it. A pixel without samples has no radiance either, unless a filtered image
/// was fed back, which is then discarded.
HWY_INLINE bool StaysAsItIs(const Joining& j, TapPattern pattern, bool lit_alone, int x, int y) {
  if (pattern == TapPattern::kIdentity) {
    return lit_alone || AllAre(true, j.before, x, y);
  }
  return pattern == TapPattern::kDisoccluded && lit_alone && AllAre(false, j.before, x, y);
}

/// Updates the history of the pixels that change, in place.
/// \param staged  results of StageRows
void ChangeRows(const Joining& j, bool lit_alone, StagedHistory* staged, int y0, int y1,
                SignalHistory* history) {
  HWY_ALIGN float joined[kHistorySlots * hn::MaxLanes(DF())];
  const int width = j.light.samples.width();
  const bool may_stay = !HasConfidence(j);
  const JoinFunction join = JoinFunctionOf(j);
  for (int y = y0; y < y1; ++y) {
    NextRow<2> next;
    next.Add(j.light.samples, y + 1);
    next.Add(history->length, y + 1);
    NextRow<kHistorySlots + 3> changes;
    changes.Add(history->colour, y + 1);
    changes.Add(history->behind, y + 1);
    changes.Add(history->mean, y + 1);
    changes.Add(history->variance, y + 1);
    changes.Add(history->weights2, y + 1);
    changes.Add(history->compressed, y + 1);
    changes.Add(j.light.colour, y + 1);
    const SlotRows rows = RowsOf(history, y);
    const float* from = staged->Row(y, LaneCount());
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      if (y + 1 < y1 && !NoSamples(j.light.samples, x, y + 1)) {
        changes.Fetch(x);
      }
      const TapPattern pattern = j.taps->Pattern(x / LaneCount(), y);
      if (IsGather(pattern)) {
        StoreSlots(j, from, rows, x, width);
        from += kHistorySlots * LaneCount();
      } else if (!(may_stay && NoSamples(j.light.samples, x, y) &&
                   StaysAsItIs(j, pattern, lit_alone, x, y))) {
        join(j, x, y, joined);
        StoreSlots(j, joined, rows, x, width);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(StageRows);
HWY_EXPORT(ChangeRows);

void AccumulateInPlace(const NewLight& light, const ReprojectionTaps& taps,
                       const HistoryLimits& limits, const AccumulateParameters& p, bool lit_alone,
                       StagedHistory* staged, SignalHistory* history) {
  staged->MakePlaces(taps.gathers);
  const Joining joining = {light, *history, &taps, limits, p, history->compressed_scale};
  ParallelRows(light.samples.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(StageRows)(joining, y0, y1, staged);
  });
  ParallelRows(light.samples.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(ChangeRows)(joining, lit_alone, staged, y0, y1, history);
  });
}

}  // namespace stillray::cpu
#endif
