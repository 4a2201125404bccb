// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/estimate_variance.h"

#include <atomic>

#include "core/check.h"
#include "core/parallel.h"
#include "denoise/simd/next_row.h"
#include "denoise/simd/normal_window.h"
#include "denoise/simd/tap_pairs.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/estimate_variance.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/edge_stopping-inl.h"
#include "denoise/simd/guide_exponents-inl.h"
#include "denoise/simd/packed_normal-inl.h"
#include "denoise/simd/vector_math-inl.h"

#ifndef STILLRAY_ESTIMATE_VARIANCE_ONCE
#define STILLRAY_ESTIMATE_VARIANCE_ONCE
namespace stillray {

inline constexpr size_t kMostSignals = 8;

/// The arguments common to all rows.
struct Estimates {
  std::span<const VarianceSignal> signals;
  const GuidePlanes& guides;
  const EstimateVarianceParameters& p;
  const TapPairs& taps;
};

}  // namespace stillray
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// The history of one signal at some pixels.
struct HistoryMoments {
  VF length, variance, weights2;
  VF samples;  ///< of this frame, at least one
};

struct TemporalVariance {
  VF value;     ///< 0 if the history is too short
  MF is_short;  ///< the history is too short
  MF missing;   ///< surfaces without samples
};

HWY_INLINE VF VarianceOfMean(VF variance, VF weights2) {
  const DF d;
  const VF least = hn::Max(hn::Sub(hn::Set(d, 1.0f), weights2), hn::Set(d, 0.25f));
  return hn::Mul(hn::Div(variance, least), weights2);
}

/// \param in_row  lanes inside the row
HWY_INLINE TemporalVariance TemporalVarianceOf(const HistoryMoments& m, MF surface, MF in_row,
                                               const EstimateVarianceParameters& p) {
  const DF d;
  const MF known = hn::And(hn::Gt(m.length, hn::Zero(d)), surface);
  const MF full = hn::Ge(m.length, hn::Set(d, p.short_history_length));
  const VF variance = p.variance_of_mean != 0 ? VarianceOfMean(m.variance, m.weights2)
                                              : hn::Div(m.variance, m.samples);
  return {hn::IfThenElseZero(hn::And(known, full), variance),
          hn::AndNot(full, hn::And(known, in_row)), hn::AndNot(known, surface)};
}

/// Samples of this frame, at least one.
HWY_INLINE VF Samples(const VarianceSignal& signal, int x, int y) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  return signal.samples != nullptr ? hn::Max(hn::LoadU(d, signal.samples->Row(y) + x), one) : one;
}

HWY_INLINE VF ShortHistoryBoost(VF length, float full, float boost) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF ratio = hn::Max(hn::Div(hn::Set(d, full), hn::Max(length, one)), one);
  return Exp2(hn::Mul(hn::Set(d, boost), Log2(ratio)));
}

/// Sums over a neighbourhood: of differences from the centre's mean, and of second differences.
struct SpreadSums {
  VF weight, d, d2, variance;
  VF difference_weight, difference2;
};

/// One signal's history at the pixels x, x + 1, ... of a row.
struct SpreadRow {
  const float* length;
  const float* mean;
  const float* variance;
};

/// Adds one tap to the sums. \return the weight where there are samples, else 0
HWY_INLINE VF AddSpread(const SpreadRow& row, ptrdiff_t q, VF weight, VF centre, SpreadSums* sums) {
  const DF d;
  const MF known = hn::Gt(hn::LoadU(d, row.length + q), hn::Zero(d));
  const VF w = hn::IfThenElseZero(known, weight);
  const VF difference = hn::Sub(hn::LoadU(d, row.mean + q), centre);
  sums->weight = hn::Add(sums->weight, w);
  sums->d = hn::MulAdd(w, difference, sums->d);
  sums->d2 = hn::MulAdd(w, hn::Mul(difference, difference), sums->d2);
  sums->variance = hn::MulAdd(w, hn::LoadU(d, row.variance + q), sums->variance);
  return w;
}

/// The weights of a neighbourhood, row by row.
using WindowVectors = float[2 * TapPairs::kMost + 1][hn::MaxLanes(DF())];

/// Adds the second difference of three collinear pixels.
/// \param at    index of the middle pixel in `weights`; the others are at -next and +next
/// \param q     address of the middle pixel's value; the others are at -distance and +distance
HWY_INLINE void AddSecondDifference(const WindowVectors& weights, int at, int next, const float* q,
                                    ptrdiff_t distance, SpreadSums* sums) {
  const DF d;
  const VF middle = hn::LoadU(d, q);
  const VF ends = hn::Add(hn::LoadU(d, q - distance), hn::LoadU(d, q + distance));
  const VF difference = hn::Sub(ends, hn::Add(middle, middle));
  const VF outer = hn::Mul(hn::Load(d, weights[at - next]), hn::Load(d, weights[at + next]));
  const VF w = hn::Mul(outer, hn::Load(d, weights[at]));
  sums->difference_weight = hn::Add(sums->difference_weight, w);
  sums->difference2 = hn::MulAdd(w, hn::Mul(difference, difference), sums->difference2);
}

/// Adds the second differences along all rows and columns.
/// \param mean  address of the centre's value
HWY_INLINE void AddSecondDifferences(const WindowVectors& weights, int radius, const float* mean,
                                     ptrdiff_t stride, SpreadSums* sums) {
  const int side = 2 * radius + 1;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const float* q = mean + (row - radius) * stride + (column - radius);
      const int at = row * side + column;
      if (column > 0 && column + 1 < side) {
        AddSecondDifference(weights, at, 1, q, 1, sums);
      }
      if (row > 0 && row + 1 < side) {
        AddSecondDifference(weights, at, side, q, stride, sums);
      }
    }
  }
}

HWY_INLINE VF SecondDifferenceVariance(const SpreadSums& sums, VF spread) {
  const DF d;
  const VF share = hn::Set(d, kSpreadWeight);
  const VF sum = hn::MulAdd(
      share, spread, hn::Mul(sums.difference2, hn::Set(d, 1.0f / kSecondDifferenceVariances)));
  return hn::Div(sum, hn::Add(sums.difference_weight, share));
}

/// Variance of single samples from the neighbourhood on the same surface.
HWY_INLINE VF SpatialVariance(const Estimates& e, const SignalHistory& h, const TapVectors& weights,
                              int x, int y) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const SpreadRow row = {h.length.Row(y), h.mean.Row(y), h.variance.Row(y)};
  const VF centre = hn::LoadU(d, row.mean + x);
  const ptrdiff_t stride = h.mean.stride();
  const bool by_differences = e.p.short_history == kShortHistorySecondDifference;
  const int side = 2 * e.p.short_history_radius + 1;
  const int middle = side * side / 2;
  HWY_ALIGN WindowVectors window;
  SpreadSums sums = {zero, zero, zero, zero, zero, zero};
  hn::Store(AddSpread(row, x, one, centre, &sums), d, window[middle]);
  for (int i = 0; i < e.taps.count; ++i) {
    const TapPair& pair = e.taps.pair[i];
    // The borders of history and guides differ.
    const ptrdiff_t distance =
        static_cast<ptrdiff_t>(pair.dy) * stride + static_cast<ptrdiff_t>(pair.dx);
    const int place = static_cast<int>(pair.dy) * side + static_cast<int>(pair.dx);
    const VF after = AddSpread(row, x + distance, hn::Load(d, weights[2 * i]), centre, &sums);
    const VF before = AddSpread(row, x - distance, hn::Load(d, weights[2 * i + 1]), centre, &sums);
    hn::Store(after, d, window[middle + place]);
    hn::Store(before, d, window[middle - place]);
  }
  const MF any = hn::Gt(sums.weight, zero);
  const VF scale = hn::Div(one, hn::IfThenElse(any, sums.weight, one));
  const VF mean_d = hn::Mul(sums.d, scale);
  VF between = hn::Max(hn::NegMulAdd(mean_d, mean_d, hn::Mul(sums.d2, scale)), zero);
  if (by_differences) {
    AddSecondDifferences(window, e.p.short_history_radius, row.mean + x, stride, &sums);
    between = SecondDifferenceVariance(sums, between);
  }
  const VF estimate = hn::IfThenElseZero(any, hn::MulAdd(sums.variance, scale, between));
  return hn::IfThenElse(hn::Lt(sums.weight, hn::Set(d, e.p.least_evidence)),
                        hn::Set(d, kUnknownVariance), estimate);
}

HWY_INLINE void FindWeights(const Estimates& e, const NormalRows& normals, int x, int y,
                            TapVectors& weights) {
  const EdgeStopping& edges = e.p.edges;
  const GuideRow guide = GuideRowOf(e.guides, normals, edges, y);
  const GuideCentre centre = LoadGuideCentre(guide, edges, x);
  const TapSlots slots = SlotsOf(weights);
  if (edges.depth_weight_position != 0) {
    PositionExponents(e.taps, edges, false, guide, centre, x, y, slots);
    WeightsOfExponents(e.taps, slots);
    return;
  }
  switch (NormalsOf(edges)) {
    case Normals::kLogarithm:
    case Normals::kCubic:
      GuideExponents<Normals::kLogarithm>(e.taps, edges, false, guide, centre, x, slots);
      break;
    case Normals::kParabola:
      GuideExponents<Normals::kParabola>(e.taps, edges, false, guide, centre, x, slots);
      break;
    case Normals::kCurved:
      GuideExponents<Normals::kCurved>(e.taps, edges, false, guide, centre, x, slots);
      break;
  }
  WeightsOfExponents(e.taps, slots);
}

/// The temporal variance of one signal at the pixels x, x + 1, ...
HWY_INLINE TemporalVariance VarianceOfHistory(const Estimates& e, const VarianceSignal& signal,
                                              int x, int y) {
  const DF d;
  const SignalHistory& h = *signal.history;
  const HistoryMoments moments = {hn::LoadU(d, h.length.Row(y) + x),
                                  hn::LoadU(d, h.variance.Row(y) + x),
                                  hn::LoadU(d, h.weights2.Row(y) + x), Samples(signal, x, y)};
  const MF surface = hn::Gt(hn::LoadU(d, e.guides.inverse_depth.Row(y) + x), hn::Zero(d));
  return TemporalVarianceOf(moments, surface, InRow(x, signal.variance->width()), e.p);
}

/// The variance of a short history, from the neighbourhood.
HWY_INLINE VF ShortHistoryVariance(const Estimates& e, const VarianceSignal& signal,
                                   const TapVectors& weights, int x, int y) {
  const DF d;
  const SignalHistory& history = *signal.history;
  const VF length = hn::LoadU(d, history.length.Row(y) + x);
  const VF spatial =
      hn::Mul(SpatialVariance(e, history, weights, x, y),
              ShortHistoryBoost(length, e.p.short_history_length, e.p.short_history_boost));
  return e.p.variance_of_mean != 0 ? hn::Mul(spatial, hn::LoadU(d, history.weights2.Row(y) + x))
                                   : hn::Div(spatial, Samples(signal, x, y));
}

/// The inputs and outputs of the next row.
NextRow<1 + 5 * kMostSignals> NextRowOf(const Estimates& e, int y) {
  NextRow<1 + 5 * kMostSignals> next;
  next.Add(e.guides.inverse_depth, y);
  for (const VarianceSignal& signal : e.signals) {
    for (const Image1* plane :
         {&signal.history->length, &signal.history->weights2, &signal.history->variance,
          static_cast<const Image1*>(signal.variance)}) {
      next.Add(*plane, y);
    }
    if (signal.samples != nullptr) {
      next.Add(*signal.samples, y);
    }
  }
  return next;
}

/// \return one bit for each signal with surfaces that have no samples
uint32_t EstimateVarianceRows(const Estimates& all, int y0, int y1) {
  const DF d;
  const TapPairs taps = WithBias(all.taps, all.p.edges, NormalsOf(all.p.edges));
  const Estimates e = {all.signals, all.guides, all.p, taps};
  NormalWindow window(all.guides, 1, all.p.short_history_radius);
  uint32_t incomplete = 0;
  const int width = e.guides.id.width();
  HWY_ALIGN TapVectors weights;
  for (int y = y0; y < y1; ++y) {
    const auto next = NextRowOf(e, y + 1);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      bool has_weights = false;
      for (size_t i = 0; i < e.signals.size(); ++i) {
        const VarianceSignal& signal = e.signals[i];
        const TemporalVariance temporal = VarianceOfHistory(e, signal, x, y);
        VF result = temporal.value;
        incomplete |= hn::AllFalse(d, temporal.missing) ? 0u : 1u << i;
        if (e.p.short_history != kShortHistoryNone && !hn::AllFalse(d, temporal.is_short)) {
          if (!has_weights) {
            FindWeights(e, NormalsAround(e.guides, y, &window), x, y, weights);
            has_weights = true;
          }
          result = hn::IfThenElse(temporal.is_short, ShortHistoryVariance(e, signal, weights, x, y),
                                  result);
        }
        StoreInRow(d, result, signal.variance->Row(y), x, width);
      }
    }
  }
  return incomplete;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(EstimateVarianceRows);

void EstimateVariance(std::span<VarianceSignal> signals, const GuidePlanes& guides,
                      const EstimateVarianceParameters& p) {
  STILLRAY_CHECK_LE(signals.size(), kMostSignals);
  constexpr float kLog2OfOnes[SignalHistory::kBorder + 1] = {};
  STILLRAY_CHECK_LE(p.short_history_radius, SignalHistory::kBorder);
  const std::span<const float> row(kLog2OfOnes, static_cast<size_t>(p.short_history_radius) + 1);
  const TapPairs taps = MakeTapPairs(row, 1, guides.inverse_depth.stride(),
                                     NormalWindow::RowDistance(guides, 1, p.short_history_radius));
  const Estimates estimates = {signals, guides, p, taps};
  std::atomic<uint32_t> incomplete = 0;
  ParallelRows(guides.id.height(), 16, [&](int y0, int y1) {
    incomplete |= HWY_DYNAMIC_DISPATCH(EstimateVarianceRows)(estimates, y0, y1);
  });
  for (size_t i = 0; i < signals.size(); ++i) {
    signals[i].all_valid = (incomplete >> i & 1u) == 0;
  }
}

}  // namespace stillray::cpu
#endif
