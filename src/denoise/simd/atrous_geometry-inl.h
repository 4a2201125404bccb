// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Levels of the wavelet with geometry-only weights, which all signals share.
#if defined(STILLRAY_DENOISE_SIMD_ATROUS_GEOMETRY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_ATROUS_GEOMETRY_INL_H_
#undef STILLRAY_DENOISE_SIMD_ATROUS_GEOMETRY_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_ATROUS_GEOMETRY_INL_H_
#endif

#include <algorithm>

#include "denoise/row_scratch.h"
#include "denoise/simd/atrous_rows-inl.h"
#include "denoise/simd/mix_pilot-inl.h"
#include "denoise/simd/sparse_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Whether any signal has samples at the pixels x, x + 1, ... of a row, which may lie in the
/// border.
HWY_INLINE bool AnyPresent(const AtrousPass& pass, int y, int x) {
  const DF d;
  VF valid = hn::Zero(d);
  for (const AtrousSignal& signal : pass.signals) {
    valid = hn::Max(valid, hn::LoadU(d, signal.valid->Row(y) + x));
  }
  return !hn::AllFalse(d, hn::And(hn::Gt(valid, hn::Zero(d)), InRow(x, pass.guides->id.width())));
}

struct GeometrySums {
  VF luminance, red, variance, weight;
};

/// Adds one tap of a signal. Pixels without samples may hold any value, even NaN.
HWY_INLINE void AddGeometryTap(const SignalRow& s, ptrdiff_t q, VF weight, GeometrySums* sums) {
  const DF d;
  const MF there = hn::Gt(hn::LoadU(d, s.valid + q), hn::Zero(d));
  const auto value = [&](const float* row)
                         HWY_ATTR { return hn::IfThenElseZero(there, hn::LoadU(d, row + q)); };
  sums->luminance = hn::MulAdd(weight, value(s.luminance), sums->luminance);
  sums->red = hn::MulAdd(weight, value(s.red), sums->red);
  sums->variance = hn::MulAdd(hn::Mul(weight, weight), value(s.variance), sums->variance);
  sums->weight = hn::Add(sums->weight, hn::IfThenElseZero(there, weight));
}

HWY_INLINE GeometrySums SumGeometryTaps(const TapPairs& taps, float centre_kernel,
                                        const SignalRow& row, const TapVectors& weights, int x) {
  const DF d;
  const VF zero = hn::Zero(d);
  GeometrySums sums = {zero, zero, zero, zero};
  AddGeometryTap(row, x, hn::Set(d, centre_kernel), &sums);
  for (int i = 0; i < taps.count; ++i) {
    const ptrdiff_t distance = taps.pair[i].distance;
    AddGeometryTap(row, x + distance, hn::Load(d, weights[2 * i]), &sums);
    AddGeometryTap(row, x - distance, hn::Load(d, weights[2 * i + 1]), &sums);
  }
  return sums;
}

/// Sums of a dense signal: every surface has samples (kComplete), or every plane is zero where
/// there are none.
template <int kPairs, bool kComplete, bool kRed>
HWY_INLINE GeometrySums SumDenseTaps(const TapPairs& taps, float centre_kernel,
                                     const SignalRow& row, TapSlots weights, int x) {
  const DF d;
  const VF zero = hn::Zero(d);
  GeometrySums sums = {zero, zero, zero, zero};
  const auto add = [&](ptrdiff_t q, VF weight) HWY_ATTR __attribute__((always_inline)) {
    sums.luminance = hn::MulAdd(weight, hn::LoadU(d, row.luminance + q), sums.luminance);
    if constexpr (kRed) {
      sums.red = hn::MulAdd(weight, hn::LoadU(d, row.red + q), sums.red);
    }
    sums.variance =
        hn::MulAdd(hn::Mul(weight, weight), hn::LoadU(d, row.variance + q), sums.variance);
    sums.weight = kComplete ? hn::Add(weight, sums.weight)
                            : hn::MulAdd(weight, hn::LoadU(d, row.valid + q), sums.weight);
  };
  add(x, hn::Set(d, centre_kernel));
  ForEachPair<kPairs>(
      taps, [&](int i) HWY_ATTR __attribute__((always_inline)) {
        const float* weight = weights.first + 2 * i * weights.stride + x;
        add(x + taps.pair[i].distance, hn::Load(d, weight));
        add(x - taps.pair[i].distance, hn::Load(d, weight + weights.stride));
      });
  return sums;
}

/// Use of the means of a dense signal.
enum class Means { kStored, kLuminanceAlone, kMixedPilot };

/// Filters a row of one dense signal.
template <int kPairs, bool kComplete, Means kMeans>
HWY_NOINLINE void FilterDenseRow(const AtrousPass& pass, const AtrousSignal& signal, int y,
                                 TapSlots weights) {
  constexpr bool kRed = kMeans == Means::kStored;
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const TapPairs taps = pass.taps;
  const float centre_kernel = pass.centre_kernel;
  const SignalRow row = RowOf(signal, y);
  const OutputRow out = OutputOf(signal, y);
  const float* length = kMeans == Means::kMixedPilot ? signal.mixed_length->Row(y) : nullptr;
  const float full = signal.mixed_full;
  const NextSignal next = NextSignalOf(pass, signal, false, y);
  const int width = pass.guides->id.width();
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    const MF present = hn::Gt(hn::LoadU(d, row.valid + x), zero);
    GeometrySums sums = {zero, zero, zero, zero};
    VF scale = zero;
    if (!hn::AllFalse(d, present)) {
      sums = SumDenseTaps<kPairs, kComplete, kRed>(taps, centre_kernel, row, weights, x);
      scale = hn::IfThenElseZero(present, hn::Div(one, hn::IfThenElse(present, sums.weight, one)));
    }
    PilotValue mean = {hn::Mul(sums.luminance, scale),
                       hn::Mul(sums.variance, hn::Mul(scale, scale))};
    if constexpr (kMeans == Means::kMixedPilot) {
      mean = MixedPilot({hn::LoadU(d, row.luminance + x), hn::LoadU(d, row.variance + x)}, mean,
                        hn::LoadU(d, length + x), full);
    }
    StreamInRow(d, mean.luminance, out.value[0], x, width);
    if constexpr (kRed) {
      StreamInRow(d, hn::Mul(sums.red, scale), out.value[1], x, width);
    }
    StreamInRow(d, mean.variance, out.value[3], x, width);
  }
}

template <int kPairs>
void FilterDenseRow(const AtrousPass& pass, const AtrousSignal& signal, int y, TapSlots weights) {
  if (!signal.all_valid) {
    FilterDenseRow<kPairs, false, Means::kStored>(pass, signal, y, weights);
  } else if (signal.mixed_length != nullptr) {
    FilterDenseRow<kPairs, true, Means::kMixedPilot>(pass, signal, y, weights);
  } else if (signal.luminance_only) {
    FilterDenseRow<kPairs, true, Means::kLuminanceAlone>(pass, signal, y, weights);
  } else {
    FilterDenseRow<kPairs, true, Means::kStored>(pass, signal, y, weights);
  }
}

/// Whether all signals are dense, so that no pixel has to be tested for samples.
inline bool IsDense(const AtrousPass& pass) {
  return std::all_of(pass.signals.begin(), pass.signals.end(),
                     [](const AtrousSignal& s) { return s.all_valid || s.zero_where_absent; });
}

/// Filters one row of all signals with the shared geometry-only weights, in vectors with a sample.
/// \tparam kNormals  not with Depths::kPosition
template <Normals kNormals, Depths kDepths>
void FilterRowByGeometry(const AtrousPass& pass, int y) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const EdgeStopping edges = pass.parameters->edges;
  const TapPairs taps = WithBias(pass.taps, edges, NormalsOf(edges));
  const GuideRow guide = GuideRowOf<kDepths>(*pass.guides, pass.normals, edges, y);
  const int width = pass.guides->id.width();
  SignalRow rows[kMostSignals];
  OutputRow outputs[kMostSignals];
  for (size_t i = 0; i < pass.signals.size(); ++i) {
    rows[i] = RowOf(pass.signals[i], y);
    outputs[i] = OutputOf(pass.signals[i], y);
  }
  // If samples are rare, neighbouring pixels have not loaded their data into the cache.
  const bool sparse = IsSparseRow(rows[0].valid, width);
  const NextGuides next_guides = NextGuidesOf(pass, sparse, y);
  NextSignal next[kMostSignals];
  for (size_t i = 0; i < pass.signals.size(); ++i) {
    next[i] = NextSignalOf(pass, pass.signals[i], sparse, y);
  }
  HWY_ALIGN TapVectors weights;
  for (int x = 0; x < width; x += LaneCount()) {
    if (!sparse || AnyPresent(pass, y + pass.level->step, x)) {
      next_guides.Fetch(x);
      for (size_t i = 0; i < pass.signals.size(); ++i) {
        next[i].Fetch(x);
      }
    }
    if (!AnyPresent(pass, y, x)) {
      continue;
    }
    const GuideCentre c = LoadGuideCentre<kDepths>(guide, edges, x);
    if constexpr (kDepths == Depths::kPosition) {
      PositionExponents(taps, edges, false, guide, c, x, y, SlotsOf(weights));
    } else {
      GuideExponents<kNormals, kDepths>(taps, edges, false, guide, c, x, SlotsOf(weights));
    }
    WeightsOfExponents(taps, SlotsOf(weights));
    for (size_t i = 0; i < pass.signals.size(); ++i) {
      const GeometrySums sums = SumGeometryTaps(taps, pass.centre_kernel, rows[i], weights, x);
      const VF scale = hn::Div(one, hn::IfThenElse(hn::Gt(sums.weight, zero), sums.weight, one));
      StreamInRow(d, hn::Mul(sums.luminance, scale), outputs[i].value[0], x, width);
      StreamInRow(d, hn::Mul(sums.red, scale), outputs[i].value[1], x, width);
      StreamInRow(d, hn::Mul(sums.variance, hn::Mul(scale, scale)), outputs[i].value[3], x, width);
    }
  }
}

void FilterRowByGeometry(const AtrousPass& pass, int y) {
  const EdgeStopping& edges = pass.parameters->edges;
  const bool plane = edges.depth_weight_plane != 0;
  if (edges.depth_weight_position != 0) {
    FilterRowByGeometry<Normals::kLogarithm, Depths::kPosition>(pass, y);
    return;
  }
  switch (NormalsOf(edges)) {
    case Normals::kLogarithm:
    case Normals::kCubic:
      FilterRowByGeometry<Normals::kLogarithm, Depths::kEither>(pass, y);
      break;
    case Normals::kParabola:
      plane ? FilterRowByGeometry<Normals::kParabola, Depths::kPlane>(pass, y)
            : FilterRowByGeometry<Normals::kParabola, Depths::kGradient>(pass, y);
      break;
    case Normals::kCurved:
      plane ? FilterRowByGeometry<Normals::kCurved, Depths::kPlane>(pass, y)
            : FilterRowByGeometry<Normals::kCurved, Depths::kEither>(pass, y);
      break;
  }
}

/// Filters one row of all signals with the geometry-only weights, if all are dense: computes the
/// weights first, then filters signal by signal.
template <int kPairs>
void FilterDenseRows(const AtrousPass& pass, int y) {
  const RowScratch scratch(pass.guides->id.width(), 2 * kPairs);
  const TapSlots weights = {scratch.Row(0), scratch.Row(1) - scratch.Row(0)};
  ExponentsOfRow<kPairs, OfGuides::kWeights>(pass, y, weights);
  for (const AtrousSignal& signal : pass.signals) {
    FilterDenseRow<kPairs>(pass, signal, y, weights);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
