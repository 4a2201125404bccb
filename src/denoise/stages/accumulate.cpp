// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/accumulate.h"

#include <atomic>

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/picture_parts.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/accumulate.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/temporal_variance-inl.h"
#include "denoise/simd/vector_math-inl.h"

#ifndef STILLRAY_ACCUMULATE_ONCE
#define STILLRAY_ACCUMULATE_ONCE
namespace stillray {

/// What joins the history, and how.
struct Joining {
  const NewLight& light;
  const SignalHistory& before;
  const ReprojectionTaps* taps;
  const Image1* limit;
  const AccumulateParameters& p;
};

/// One row of new light.
struct LightRow {
  const float* colour[3];
  const float* samples;
};

inline LightRow LightRowOf(const NewLight& light, int y) {
  return {{light.colour[0].Row(y), light.colour[1].Row(y), light.colour[2].Row(y)},
          light.samples.Row(y)};
}

/// What a band of rows has found.
struct RadianceRows {
  DemodulateCounts counts;
  bool complete = true;  ///< see VarianceOnTheWay
};

}  // namespace stillray
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE VF NewFrameWeight(VF length, VF n, float alpha_min, bool constant_weight) {
  const DF d;
  const VF share = hn::Div(n, hn::Max(hn::Add(length, n), hn::Set(d, 1e-6f)));
  const VF least = hn::Set(d, alpha_min);
  const VF alpha = hn::Min(constant_weight ? least : hn::Max(least, share), hn::Set(d, 1.0f));
  const VF with_history = hn::IfThenElse(hn::Gt(length, hn::Zero(d)), alpha, hn::Set(d, 1.0f));
  return hn::IfThenElseZero(hn::Gt(n, hn::Zero(d)), with_history);
}

/// The planes of a history in the order of their slots; nullptr where it has none.
struct SlotRows {
  float* row[kHistorySlots];
};

SlotRows RowsOf(SignalHistory* history, int y) {
  SlotRows rows;
  const auto row_of = [&](Image1& plane) { return plane.empty() ? nullptr : plane.Row(y); };
  for (int c = 0; c < 3; ++c) {
    rows.row[kColourSlot + c] = row_of(history->colour[c]);
    rows.row[kBehindSlot + c] = row_of(history->behind[c]);
  }
  rows.row[kMeanSlot] = row_of(history->mean);
  rows.row[kVarianceSlot] = row_of(history->variance);
  rows.row[kLengthSlot] = row_of(history->length);
  rows.row[kWeights2Slot] = row_of(history->weights2);
  rows.row[kCompressedSlot] = row_of(history->compressed);
  return rows;
}

/// The history of the pixels x, x + 1, ... of row y with the new light.
/// \param old_of  takes a plane of the history before: its values there; Length() for its length
/// \param store   takes a slot and a vector of its values
template <typename OldOf, typename Store>
HWY_INLINE void JoinOld(const Joining& j, const LightRow& light, bool nothing_new, int x, int y,
                        const OldOf& old_of, const Store& store) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const AccumulateParameters& p = j.p;
  const SignalHistory& before = j.before;
  const VF n = hn::LoadU(d, light.samples + x);
  const VF old_length = old_of.Length();
  VF length = old_length;
  if (j.limit != nullptr) {
    length = hn::Min(length, hn::LoadU(d, j.limit->Row(y) + x));
  }
  if (p.max_history > 0) {
    length = hn::Min(
        length, hn::Max(hn::Sub(hn::Set(d, static_cast<float>(p.max_history)), n), hn::Zero(d)));
  }
  const VF alpha = NewFrameWeight(length, n, p.alpha_min, p.constant_weight);
  const VF alpha_moments = NewFrameWeight(length, n, p.alpha_moments, p.constant_weight);
  VF colour[3];
  for (int c = 0; c < 3; ++c) {
    colour[c] = nothing_new ? hn::Zero(d) : hn::LoadU(d, light.colour[c] + x);
    const VF old = old_of(before.colour[c]);
    store(kColourSlot + c, hn::MulAdd(alpha, hn::Sub(colour[c], old), old));
    if (!before.behind.empty()) {
      const VF behind = old_of(before.behind[c]);
      store(kBehindSlot + c, hn::MulAdd(alpha, hn::Sub(colour[c], behind), behind));
    }
  }
  const VF mean = old_of(before.mean);
  const VF variance = old_of(before.variance);
  const VF weights2 = old_of(before.weights2);
  const VF l = colour[0];
  if (p.compressed_scale > 0) {
    const VF old = old_of(before.compressed);
    const VF light_l = hn::Max(l, hn::Zero(d));
    const VF c = hn::Div(light_l, hn::Add(light_l, hn::Set(d, p.compressed_scale)));
    store(kCompressedSlot, hn::MulAdd(alpha, hn::Sub(c, old), old));
  }
  const VF difference = hn::Sub(l, mean);
  const VF keep = hn::Sub(one, alpha_moments);
  VF mixed = hn::Mul(keep, hn::MulAdd(hn::Mul(alpha_moments, difference), difference, variance));
  if (!j.light.within.empty()) {
    mixed = hn::MulAdd(alpha_moments, hn::LoadU(d, j.light.within.Row(y) + x), mixed);
  }
  const VF keep_light = hn::Sub(one, alpha);
  const MF arrived = hn::Gt(n, hn::Zero(d));
  const VF added = hn::Div(hn::Mul(alpha, alpha), hn::IfThenElse(arrived, n, one));
  const VF new_weights2 = hn::MulAdd(hn::Mul(keep_light, keep_light), weights2, added);
  store(kVarianceSlot, mixed);
  store(kMeanSlot, hn::MulAdd(alpha_moments, difference, mean));
  store(kWeights2Slot, hn::IfThenElse(arrived, new_weights2, weights2));
  store(kLengthSlot, hn::IfThenElse(arrived, hn::Add(length, n), old_length));
}

/// A history that lies at the pixels themselves.
struct OwnHistory {
  const SignalHistory& before;
  int x, y;

  HWY_INLINE VF operator()(const Image1& plane) const { return hn::LoadU(DF(), plane.Row(y) + x); }
  HWY_INLINE VF Length() const { return (*this)(before.length); }
};

template <typename Store>
HWY_INLINE void JoinVector(const Joining& j, const LightRow& light, bool nothing_new, int x, int y,
                           const Store& store) {
  if (j.taps == nullptr) {
    JoinOld(j, light, nothing_new, x, y, OwnHistory{j.before, x, y}, store);
    return;
  }
  WithHistory(
      j.before, *j.taps, x, y, [&](const auto& old_of) HWY_ATTR __attribute__((always_inline)) {
        JoinOld(j, light, nothing_new, x, y, old_of, store);
      });
}

constexpr size_t kMostFetched = 80;

/// What the next row reads and writes, but for the new light.
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

/// Whether a block is open, after its last vector.
HWY_INLINE void MarkOpen(MF is_short, int x, uint32_t* row) {
  static_assert(kBlockPixels % hn::MaxLanes(DF()) == 0);
  uint32_t& block = row[x / kBlockPixels];
  const bool any = !hn::AllFalse(DF(), is_short);
  block = any || (x % kBlockPixels != 0 && block != 0) ? 1 : 0;
}

/// \param variance  wanted (kVariance), or nullptr
/// \return whether every surface has light, where that is asked for
template <bool kVariance>
bool AccumulateRow(const Joining& j, const LightRow& light, const NextRow<kMostFetched>& next,
                   bool sparse, int y, const VarianceOnTheWay* variance, SignalHistory* out) {
  const DF d;
  const int width = j.light.samples.width();
  const SlotRows rows = RowsOf(out, y);
  bool complete = true;
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    if (j.taps != nullptr) {
      FetchScattered(*j.taps, x, y);
    }
    const bool nothing_new = sparse && NoSamples(light.samples, x, width);
    HistoryMoments moments;
    JoinVector(j, light, nothing_new, x, y, [&](int slot, VF value) HWY_ATTR {
      if (kVariance && slot == kVarianceSlot) {
        moments.variance = value;
      } else if (kVariance && slot == kWeights2Slot) {
        moments.weights2 = value;
      } else if (kVariance && slot == kLengthSlot) {
        moments.length = value;
      }
      StreamInRow(d, value, rows.row[slot], x, width);
    });
    if constexpr (kVariance) {
      moments.samples = hn::Max(hn::LoadU(d, light.samples + x), hn::Set(d, 1.0f));
      const VF i = hn::LoadU(d, variance->guides.inverse_depth.Row(y) + x);
      const MF surface = hn::Gt(i, hn::Zero(d));
      const TemporalVariance temporal =
          TemporalVarianceOf(moments, surface, InRow(x, width), variance->p);
      StreamInRow(d, temporal.value, variance->variance->Row(y), x, width);
      MarkOpen(temporal.is_short, x, variance->open->Row(y));
      complete = complete && hn::AllFalse(d, temporal.missing);
    }
  }
  return complete;
}

void AccumulateRows(const Joining& j, int y0, int y1, SignalHistory* out) {
  for (int y = y0; y < y1; ++y) {
    const bool sparse = IsSparseRow(j.light.samples.Row(y), j.light.samples.width());
    NextRow<kMostFetched> next = NextRowOf(j, *out, y);
    if (!sparse) {
      next.Add(j.light.colour, y + 1);
    }
    next.Add(j.light.samples, y + 1);
    AccumulateRow<false>(j, LightRowOf(j.light, y), next, sparse, y, nullptr, out);
  }
  FinishStreams();
}

/// Makes each row of light just before it joins the history.
RadianceRows AccumulateRadianceRows(const Joining& j, const DemodulateInput& radiance, int y0,
                                    int y1, NewLight* light, const VarianceOnTheWay* variance,
                                    SignalHistory* out) {
  const int width = light->samples.width();
  const RowScratch scratch(width, 4);
  float* const colour[3] = {scratch.Row(0), scratch.Row(1), scratch.Row(2)};
  RadianceRows found;
  for (int y = y0; y < y1; ++y) {
    // Samples that the frame does not tell apart are of use to nobody else.
    float* const samples = radiance.samples != nullptr ? light->samples.Row(y) : scratch.Row(3);
    found.counts += cpu::DemodulateRow(radiance, y, colour, samples, light);
    const LightRow row = {{colour[0], colour[1], colour[2]}, samples};
    const bool sparse = IsSparseRow(row.samples, width);
    NextRow<kMostFetched> next = NextRowOf(j, *out, y);
    if (!sparse) {
      AddRadiance(radiance, y + 1, &next);
    }
    if (radiance.samples != nullptr) {
      next.Add(light->samples, y + 1);
    }
    if (variance == nullptr) {
      AccumulateRow<false>(j, row, next, sparse, y, nullptr, out);
      continue;
    }
    next.Add(variance->guides.inverse_depth, y + 1);
    AddStreamed(*variance->variance, y + 1, &next);
    const bool complete = AccumulateRow<true>(j, row, next, sparse, y, variance, out);
    found.complete = found.complete && complete;
  }
  FinishStreams();
  return found;
}

/// Works out the vectors that read other pixels, before any of those is overwritten.
void StageRows(const Joining& j, int y0, int y1, StagedHistory* staged) {
  const DF d;
  const int width = j.light.samples.width();
  for (int y = y0; y < y1; ++y) {
    float* to = staged->Row(y, LaneCount());
    for (int x = 0; x < width && j.taps->elsewhere[static_cast<size_t>(y)] > 0; x += LaneCount()) {
      if (ReadsElsewhere(j.taps->Place(x / LaneCount(), y))) {
        JoinVector(j, LightRowOf(j.light, y), false, x, y, [&](int slot, VF value) HWY_ATTR {
          hn::StoreU(value, d, to + slot * LaneCount());
        });
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

/// Whether the history of the pixels x, x + 1, ... is what it would become without new light. What
/// has no samples has no light either, unless a filtered picture was fed back: that is forgotten.
HWY_INLINE bool StaysAsItIs(const Joining& j, HistoryPlace place, int x, int y) {
  if (place == HistoryPlace::kUnchanged) {
    return j.p.lit_alone || AllAre(true, j.before, x, y);
  }
  return place == HistoryPlace::kNowhere && j.p.lit_alone && AllAre(false, j.before, x, y);
}

/// Changes the history of those pixels that change, in place.
/// \param staged  what StageRows has worked out
void ChangeRows(const Joining& j, StagedHistory* staged, int y0, int y1, SignalHistory* history) {
  const DF d;
  const int width = j.light.samples.width();
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
      const auto store = [&](int slot, VF value)
                             HWY_ATTR { StoreInRow(d, value, rows.row[slot], x, width); };
      const HistoryPlace place = j.taps->Place(x / LaneCount(), y);
      if (ReadsElsewhere(place)) {
        for (int slot = 0; slot < kHistorySlots; ++slot) {
          if (rows.row[slot] != nullptr && (slot != kCompressedSlot || j.p.compressed_scale > 0)) {
            store(slot, hn::LoadU(d, from + slot * LaneCount()));
          }
        }
        from += kHistorySlots * LaneCount();
        continue;
      }
      const bool same = NoSamples(j.light.samples, x, y) && StaysAsItIs(j, place, x, y);
      if (!same) {
        JoinVector(j, LightRowOf(j.light, y), false, x, y, store);
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

HWY_EXPORT(AccumulateRows);
HWY_EXPORT(AccumulateRadianceRows);
HWY_EXPORT(StageRows);
HWY_EXPORT(ChangeRows);

void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const Image1* limit, const AccumulateParameters& p, SignalHistory* out) {
  const Joining joining = {light, before, taps, limit, p};
  ParallelRows(light.samples.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(AccumulateRows)(joining, y0, y1, out);
  });
}

void AccumulateInPlace(const NewLight& light, const ReprojectionTaps& taps, const Image1* limit,
                       const AccumulateParameters& p, StagedHistory* staged,
                       SignalHistory* history) {
  staged->MakePlaces(taps.elsewhere);
  const Joining joining = {light, *history, &taps, limit, p};
  ParallelRows(light.samples.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(StageRows)(joining, y0, y1, staged);
  });
  ParallelRows(light.samples.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(ChangeRows)(joining, staged, y0, y1, history);
  });
}

DemodulateCounts AccumulateRadiance(const DemodulateInput& radiance, const SignalHistory& before,
                                    const ReprojectionTaps& taps, const AccumulateParameters& p,
                                    NewLight* light, VarianceOnTheWay* variance,
                                    SignalHistory* out) {
  const Joining joining = {*light, before, &taps, nullptr, p};
  DemodulateTotal total;
  std::atomic<bool> complete = true;
  ParallelRows(light->samples.height(), 32, [&](int y0, int y1) {
    const auto found = HWY_DYNAMIC_DISPATCH(AccumulateRadianceRows)(joining, radiance, y0, y1,
                                                                    light, variance, out);
    total.Add(found.counts);
    if (!found.complete) {
      complete = false;
    }
  });
  if (variance != nullptr) {
    variance->complete = complete;
  }
  return total.Sum();
}

}  // namespace stillray::cpu
#endif
