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

#include "denoise/simd/confidence-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

#ifndef STILLRAY_PREFILTER_VARIANCE_ONCE
#define STILLRAY_PREFILTER_VARIANCE_ONCE
namespace stillray {

/// A row and the rows above and below it.
template <typename T>
struct ThreeRows {
  const T* row[3] = {};
};

template <typename T>
ThreeRows<T> ThreeRowsOf(const Plane<T>& plane, int y) {
  return {{plane.Row(y - 1), plane.Row(y), plane.Row(y + 1)}};
}

/// The inputs of one row.
struct VarianceRows {
  ThreeRows<float> variance;
  ThreeRows<float> valid;
  ThreeRows<uint32_t> full;  ///< nullptr: unknown
};

inline VarianceRows RowsOf(const SmoothVarianceInput& in, int y) {
  return {ThreeRowsOf(*in.variance, y), ThreeRowsOf(*in.valid, y),
          in.full != nullptr ? ThreeRowsOf(*in.full, y) : ThreeRows<uint32_t>()};
}

}  // namespace stillray
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Filters three values with (1 2 1).
HWY_INLINE VF Smooth(VF before, VF centre, VF after) {
  const DF d;
  return hn::MulAdd(hn::Set(d, 2.0f), centre, hn::Add(before, after));
}

/// Filters the columns with (1 2 1).
HWY_INLINE VF SmoothDown(const ThreeRows<float>& variance, int x) {
  const DF d;
  return Smooth(hn::LoadU(d, variance.row[0] + x), hn::LoadU(d, variance.row[1] + x),
                hn::LoadU(d, variance.row[2] + x));
}

/// Weighted sum of the variance over the pixels with samples, and the sum of their weights.
struct SmoothedLight {
  VF sum, weight;
};

HWY_INLINE SmoothedLight SmoothLightDown(const ThreeRows<float>& variance,
                                         const ThreeRows<float>& valid, int x) {
  const DF d;
  VF v[3];
  VF w[3];
  for (int i = 0; i < 3; ++i) {
    const MF there = hn::Gt(hn::LoadU(d, valid.row[i] + x), hn::Zero(d));
    v[i] = hn::IfThenElseZero(there, hn::LoadU(d, variance.row[i] + x));
    w[i] = hn::IfThenElseZero(there, hn::Set(d, 1.0f));
  }
  return {Smooth(v[0], v[1], v[2]), Smooth(w[0], w[1], w[2])};
}

/// Work memory of a row.
struct SmoothScratch {
  float* sums;            ///< of the variance along the columns
  uint32_t* full_around;  ///< per block: whether it and its neighbours are full
};

/// The variance of a row, optionally smoothed.
class RowVariance {
 public:
  RowVariance(const VarianceRows& rows, bool smooth, int width, const SmoothScratch& scratch)
      : rows_(rows), smooth_(smooth), scratch_(scratch) {
    const DF d;
    const bool any_full = rows.full.row[0] != nullptr;
    for (int i = 0; i < BlocksOf(width); ++i) {
      scratch.full_around[i] = any_full ? Column(i - 1) & Column(i) & Column(i + 1) : 0;
    }
    for (int x = 0; x < width && any_full && smooth; x += LaneCount()) {
      hn::Store(SmoothDown(rows.variance, x), d, scratch.sums + x);
    }
  }

  /// Whether all pixels x, x + 1, ... and their neighbours have samples.
  HWY_INLINE bool Full(int x) const { return scratch_.full_around[x / kBlockPixels] != 0; }

  HWY_INLINE VF At(int x) const { return smooth_ ? Smoothed(Full(x), x) : Own(x); }

  /// The pixels' own variance.
  HWY_INLINE VF Own(int x) const { return hn::LoadU(DF(), rows_.variance.row[1] + x); }

  /// `value` where the pixels x, x + 1, ... have samples, else `other`.
  HWY_INLINE VF WhereLit(int x, VF value, VF other) const {
    const DF d;
    const VF valid = hn::LoadU(d, rows_.valid.row[1] + x);
    return Full(x) ? value : hn::IfThenElse(hn::Gt(valid, hn::Zero(d)), value, other);
  }

 private:
  /// Whether a block and the blocks above and below it are full.
  uint32_t Column(int block) const {
    const auto& row = rows_.full.row;
    return row[0][block] & row[1][block] & row[2][block];
  }
  /// The variance, filtered with (1 2 1) x (1 2 1) over the pixels with samples.
  /// \param full  all neighbours have samples
  HWY_INLINE VF Smoothed(bool full, int x) const {
    const DF d;
    if (full) {
      const VF sum = Smooth(hn::LoadU(d, scratch_.sums + x - 1), hn::LoadU(d, scratch_.sums + x),
                            hn::LoadU(d, scratch_.sums + x + 1));
      return hn::Mul(sum, hn::Set(d, 1.0f / 16));
    }
    const SmoothedLight before = SmoothLightDown(rows_.variance, rows_.valid, x - 1);
    const SmoothedLight here = SmoothLightDown(rows_.variance, rows_.valid, x);
    const SmoothedLight after = SmoothLightDown(rows_.variance, rows_.valid, x + 1);
    const VF weight = Smooth(before.weight, here.weight, after.weight);
    return hn::Div(Smooth(before.sum, here.sum, after.sum), hn::Max(weight, hn::Set(d, 1.0f)));
  }

  const VarianceRows rows_;
  const bool smooth_;
  const SmoothScratch scratch_;
};

/// sigma_l of the pixels x, x + 1, ... of row y.
HWY_INLINE VF SigmaAt(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p, int x,
                      int y) {
  const DF d;
  const VF sigma = hn::Set(d, p.sigma_l);
  if (in.confidence == nullptr) {
    return sigma;
  }
  const VF least = hn::Set(d, kLeastConfidence);
  const VF confidence = hn::Max(ConfidenceOf(*in.confidence, x, y), least);
  const VF widening = hn::Div(hn::Set(d, 1.0f), hn::Sqrt(confidence));  // VolumeWidening
  return hn::Mul(sigma, hn::Min(widening, hn::Set(d, p.volume_widening)));
}

/// LimitedVariance for a limit above 0.
HWY_INLINE VF Limited(VF smoothed, VF own, float limit) {
  const DF d;
  const VF least = hn::Mul(hn::Set(d, kLeastOfSmoothed), smoothed);
  return hn::Min(smoothed, hn::MulAdd(hn::Set(d, limit), own, least));
}

/// LuminanceFactor of the pixels x, x + 1, ... of a row.
HWY_INLINE VF FactorAt(const RowVariance& of_row, const float* luminance, const float* length,
                       const PrefilterVarianceParameters& p, VF sigma_l, int x) {
  const DF d;
  const VF smoothed = of_row.At(x);
  const VF variance =
      p.prefilter_limit > 0 ? Limited(smoothed, of_row.Own(x), p.prefilter_limit) : smoothed;
  const VF spread = p.luminance_scale_deviation != 0 ? hn::Sqrt(variance) : variance;
  const VF l = hn::Abs(hn::LoadU(d, luminance + x));
  const VF tolerance = hn::MulAdd(
      sigma_l, spread,
      hn::MulAdd(hn::Set(d, p.luminance_epsilon), l, hn::Set(d, p.luminance_floor + 1e-12f)));
  const VF factor = of_row.WhereLit(x, hn::Div(hn::Set(d, kLog2E), tolerance), hn::Zero(d));
  if (!(p.short_history_blur > 0)) {
    return factor;
  }
  const VF old = hn::LoadU(d, length + x);
  return hn::IfThenElseZero(hn::Ge(old, hn::Set(d, p.short_history_blur)), factor);
}

/// The inputs and outputs of the next row.
NextRow<8> NextRowOf(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p, int y,
                     const Image1& factor) {
  NextRow<8> next;
  next.Add(*in.variance, y + 1);
  if (in.full == nullptr) {
    next.Add(*in.valid, y + 1);
  }
  next.Add(*in.luminance, y);
  AddStreamed(factor, y, &next);
  if (p.short_history_blur > 0) {
    next.Add(*in.length, y);
  }
  return next;
}

void PrefilterVarianceRows(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& all,
                           int y0, int y1, Image1* factor) {
  const DF d;
  const PrefilterVarianceParameters p = all;  // a local copy, since stores might alias `all`
  const int width = factor->width();
  const RowScratch scratch(width, 2);
  for (int y = y0; y < y1; ++y) {
    const RowVariance of_row(RowsOf({in.variance, in.valid, in.full}, y), p.prefilter_variance != 0,
                             width, {scratch.Row(0), scratch.Row<uint32_t>(1)});
    const float* luminance = in.luminance->Row(y);
    const float* length = in.length->Row(y);
    const NextRow<8> next = NextRowOf(in, p, y + 1, *factor);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const VF sigma_l = SigmaAt(in, p, x, y);
      StreamInRow(d, FactorAt(of_row, luminance, length, p, sigma_l, x), factor->Row(y), x, width);
    }
  }
  FinishStreams();
}

void SmoothVarianceRows(const SmoothVarianceInput& in, int y0, int y1, Image1* out) {
  const DF d;
  const int width = out->width();
  const RowScratch scratch(width, 2);
  for (int y = y0; y < y1; ++y) {
    const RowVariance of_row(RowsOf(in, y), true, width,
                             {scratch.Row(0), scratch.Row<uint32_t>(1)});
    const float* own = in.variance->Row(y);
    for (int x = 0; x < width; x += LaneCount()) {
      StreamInRow(d, of_row.WhereLit(x, of_row.At(x), hn::LoadU(d, own + x)), out->Row(y), x,
                  width);
    }
  }
  FinishStreams();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(PrefilterVarianceRows);
HWY_EXPORT(SmoothVarianceRows);

void PrefilterVariance(const PrefilterVarianceInput& in, const PrefilterVarianceParameters& p,
                       Image1* factor) {
  ParallelRows(factor->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(PrefilterVarianceRows)(in, p, y0, y1, factor);
  });
}

void SmoothVariance(const SmoothVarianceInput& in, Image1* out) {
  ParallelRows(out->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(SmoothVarianceRows)(in, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
