// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/prefilter_variance.h"

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/prefilter_variance.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// 1 2 1 of three values.
HWY_INLINE VF Smooth(VF before, VF centre, VF after) {
  const DF d;
  return hn::MulAdd(hn::Set(d, 2.0f), centre, hn::Add(before, after));
}

/// 1 2 1 across what has been smoothed down the columns.
HWY_INLINE VF SmoothAcross(const float* row, int x) {
  const DF d;
  return Smooth(hn::LoadU(d, row + x - 1), hn::LoadU(d, row + x), hn::LoadU(d, row + x + 1));
}

/// A row of a plane and those beside it.
template <typename T>
struct ThreeRows {
  const T* row[3] = {};
};

template <typename T>
ThreeRows<T> ThreeRowsOf(const Plane<T>& plane, int y) {
  return {{plane.Row(y - 1), plane.Row(y), plane.Row(y + 1)}};
}

/// Sums of the variance over the pixels that have light, and of their weights.
struct Smoothed {
  VF sum, weight;
};

/// 1 2 1 down the columns.
HWY_INLINE Smoothed SmoothDown(const ThreeRows<float>& variance, const ThreeRows<float>& present,
                               int x) {
  const DF d;
  VF v[3];
  VF w[3];
  for (int i = 0; i < 3; ++i) {
    const MF there = hn::Gt(hn::LoadU(d, present.row[i] + x), hn::Zero(d));
    v[i] = hn::IfThenElseZero(there, hn::LoadU(d, variance.row[i] + x));
    w[i] = hn::IfThenElseZero(there, hn::Set(d, 1.0f));
  }
  return {Smooth(v[0], v[1], v[2]), Smooth(w[0], w[1], w[2])};
}

/// ... where all have light.
HWY_INLINE Smoothed SmoothDown(const ThreeRows<float>& variance, int x) {
  const DF d;
  return {Smooth(hn::LoadU(d, variance.row[0] + x), hn::LoadU(d, variance.row[1] + x),
                 hn::LoadU(d, variance.row[2] + x)),
          hn::Set(d, 4.0f)};
}

/// sum / max(weight, 1). Away from edges all weights are 16: their division is exact, and costs one
/// step instead of the divider's time.
HWY_INLINE VF OverWeight(VF sum, VF weight) {
  const DF d;
  if (hn::AllTrue(d, hn::Eq(weight, hn::Set(d, 16.0f)))) {
    return hn::Mul(sum, hn::Set(d, 1.0f / 16));
  }
  return hn::Div(sum, hn::Max(weight, hn::Set(d, 1.0f)));
}

/// What the stops of one row are made from.
struct StopSource {
  const PrefilterVarianceParameters p;
  const float* luminance;
  const float* length;
  ThreeRows<float> variance;
  ThreeRows<float> present;
  ThreeRows<uint32_t> full;  ///< nullptr: not known

  StopSource(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& parameters, int y)
      : p(parameters),
        luminance(in.luminance->Row(y)),
        length(in.length->Row(y)),
        variance(ThreeRowsOf(*in.variance, y)),
        present(ThreeRowsOf(*in.present, y)) {
    if (in.full != nullptr) {
      full = ThreeRowsOf(*in.full, y);
    }
  }
};

/// Whether the block of a pixel and those above and below it are full.
HWY_INLINE bool IsFull(const StopSource& s, int x) {
  const auto& row = s.full.row;
  const int block = x / kBlockPixels;
  return row[0] != nullptr && (row[0][block] & row[1][block] & row[2][block]) != 0;
}

/// LuminanceStop of the pixels x, x + 1, ...
HWY_INLINE VF StopOf(const StopSource& s, VF variance, int x) {
  const DF d;
  const VF spread = s.p.square_root ? hn::Sqrt(variance) : variance;
  const VF l = hn::Abs(hn::LoadU(d, s.luminance + x));
  const VF tolerance =
      hn::MulAdd(hn::Set(d, s.p.sigma_l), spread,
                 hn::MulAdd(hn::Set(d, s.p.luminance_epsilon), l, hn::Set(d, 1e-12f)));
  VF stop = hn::Div(hn::Set(d, kLog2E), tolerance);
  if (!IsFull(s, x)) {
    stop = hn::IfThenElseZero(hn::Gt(hn::LoadU(d, s.present.row[1] + x), hn::Zero(d)), stop);
  }
  if (s.p.unbounded_below > 0) {
    const VF old = hn::LoadU(d, s.length + x);
    stop = hn::IfThenElseZero(hn::Ge(old, hn::Set(d, s.p.unbounded_below)), stop);
  }
  return stop;
}

/// Smooths the variance of a row down the columns. One more to the left and right: the border,
/// which has nothing.
void SmoothRowDown(const StopSource& s, int width, float* sums, float* weights) {
  const DF d;
  for (int x = 0; x < width; x += LaneCount()) {
    const Smoothed down =
        IsFull(s, x) ? SmoothDown(s.variance, x) : SmoothDown(s.variance, s.present, x);
    StoreInRow(d, down.sum, sums, x, width);
    StoreInRow(d, down.weight, weights, x, width);
  }
  sums[-1] = weights[-1] = sums[width] = weights[width] = 0;
}

/// What the next row reads and writes.
NextRow<8> NextRowOf(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p, int y,
                     const Image1& stop) {
  NextRow<8> next;
  next.Add(*in.variance, y + 1);
  if (in.full == nullptr) {
    next.Add(*in.present, y + 1);
  }
  next.Add(*in.luminance, y);
  AddStreamed(stop, y, &next);
  if (p.unbounded_below > 0) {
    next.Add(*in.length, y);
  }
  return next;
}

/// \tparam kAtOnce  what is written is read at once, so it stays in the caches
template <bool kAtOnce>
void RowInto(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
             const NextRow<8>& next, int y, float* const work[2], float* to) {
  const DF d;
  const int width = in.variance->width();
  const StopSource source(in, p, y);
  if (p.smooth) {
    SmoothRowDown(source, width, work[0], work[1]);
  }
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    const VF variance = p.smooth ? OverWeight(SmoothAcross(work[0], x), SmoothAcross(work[1], x))
                                 : hn::LoadU(d, source.variance.row[1] + x);
    const VF stop = StopOf(source, variance, x);
    kAtOnce ? StoreInRow(d, stop, to, x, width) : StreamInRow(d, stop, to, x, width);
  }
}

void PrefilterVarianceRows(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                           int y0, int y1, Image1* stop) {
  const RowScratch scratch(stop->width(), 2);
  float* const work[2] = {scratch.Row(0), scratch.Row(1)};
  for (int y = y0; y < y1; ++y) {
    RowInto<false>(in, p, NextRowOf(in, p, y + 1, *stop), y, work, stop->Row(y));
  }
  FinishStreams();
}

void RowAtOnce(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p, int y,
               float* const work[2], float* stop) {
  RowInto<true>(in, p, NextRow<8>(), y, work, stop);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(PrefilterVarianceRows);
HWY_EXPORT(RowAtOnce);

void PrefilterVarianceRow(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                          int y, float* const work[2], float* stop) {
  HWY_DYNAMIC_DISPATCH(RowAtOnce)(in, p, y, work, stop);
}

void PrefilterVariance(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                       Image1* stop) {
  ParallelRows(stop->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(PrefilterVarianceRows)(in, p, y0, y1, stop);
  });
}

}  // namespace stillray::cpu
#endif
