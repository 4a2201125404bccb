// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Images of the last frame, resampled at the previous positions of pixels over 4x4 pixels:
// Catmull-Rom, B-spline or ResampleSubcell.
#if defined(STILLRAY_DENOISE_SIMD_SAMPLE_PREVIOUS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_SAMPLE_PREVIOUS_INL_H_
#undef STILLRAY_DENOISE_SIMD_SAMPLE_PREVIOUS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_SAMPLE_PREVIOUS_INL_H_
#endif

#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/antialias_shared.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Columns clamped to the image: pixels outside repeat the edge.
HWY_INLINE VI ClampColumns(VI x, int width) {
  const DI di;
  return hn::Min(hn::Max(x, hn::Zero(di)), hn::Set(di, width - 1));
}

HWY_INLINE void CatmullRom(VF t, VF w[4]) {
  const DF d;
  const VF t2 = hn::Mul(t, t);
  const VF t3 = hn::Mul(t2, t);
  const VF half = hn::Set(d, 0.5f);
  w[0] = hn::Sub(t2, hn::Mul(half, hn::Add(t3, t)));
  w[1] =
      hn::Add(hn::MulAdd(hn::Set(d, 1.5f), t3, hn::Mul(hn::Set(d, -2.5f), t2)), hn::Set(d, 1.0f));
  w[2] = hn::MulAdd(hn::Set(d, -1.5f), t3, hn::MulAdd(hn::Set(d, 2.0f), t2, hn::Mul(half, t)));
  w[3] = hn::Mul(half, hn::Sub(t3, t2));
}

/// See antialias_shared.h.
HWY_INLINE void CubicSpline(VF t, VF w[4]) {
  const DF d;
  const VF sixth = hn::Set(d, 1.0f / 6.0f);
  const VF half = hn::Set(d, 0.5f);
  const VF t2 = hn::Mul(t, t);
  const VF s = hn::Sub(hn::Set(d, 1.0f), t);
  w[0] = hn::Mul(sixth, hn::Mul(s, hn::Mul(s, s)));
  w[1] = hn::MulAdd(t2, hn::NegMulAdd(half, s, hn::Set(d, -0.5f)), hn::Set(d, 2.0f / 3.0f));
  w[3] = hn::Mul(sixth, hn::Mul(t2, t));
  w[2] = hn::Sub(hn::Set(d, 1.0f), hn::Add(w[0], hn::Add(w[1], w[3])));
}

/// Position of a vector of pixels in the previous image: the pixel to the upper left, and the
/// fractional offset.
struct PreviousPlace {
  VI x, y;
  VF u, v;
};

HWY_INLINE VF Minmod(VF a, VF b) {
  const DF d;
  const VF zero = hn::Zero(d);
  return hn::Add(hn::Max(hn::Min(a, b), zero), hn::Min(hn::Max(a, b), zero));
}

/// A fractional offset t of a vector of pixels, for ResampleSubcell.
struct SubcellWeights {
  VF t, last;     ///< last: 1 - t
  VF begin, end;  ///< Catmull-Rom's share of the second differences

  explicit SubcellWeights(VF offset) : t(offset) {
    const DF d;
    last = hn::Sub(hn::Set(d, 1.0f), t);
    const VF both = hn::Mul(hn::Set(d, -0.5f * (1.0f - kStepShare)), hn::Mul(t, last));
    begin = hn::Mul(both, last);
    end = hn::Mul(both, t);
  }
};

/// ResampleSubcell for a vector of pixels.
HWY_INLINE VF ResampleSubcell(const VF taps[4], const SubcellWeights& w) {
  const DF d;
  const VF before = hn::Sub(taps[1], taps[0]);
  const VF between = hn::Sub(taps[2], taps[1]);
  const VF after = hn::Sub(taps[3], taps[2]);
  const VF moved = hn::Mul(w.t, between);
  const VF steps = hn::Sub(Minmod(hn::Mul(w.t, before), hn::Sub(between, moved)),
                           Minmod(hn::Mul(w.last, after), moved));
  VF sum = hn::MulAdd(hn::Set(d, kStepShare), steps, hn::Add(taps[1], moved));
  sum = hn::MulAdd(w.begin, hn::Sub(between, before), sum);
  return hn::MulAdd(w.end, hn::Sub(after, between), sum);
}

/// ResampleSubcell along rows, then along columns. \param load  see SampleTaps
template <typename Load>
HWY_INLINE void SampleSubcell(const PreviousPlace& place, const Load& load, VF before[3]) {
  const SubcellWeights wx(place.u);
  const SubcellWeights wy(place.v);
  for (int c = 0; c < 3; ++c) {
    VF rows[4];
    for (int j = 0; j < 4; ++j) {
      const VF taps[4] = {load(-1, j - 1, c), load(0, j - 1, c), load(1, j - 1, c),
                          load(2, j - 1, c)};
      rows[j] = ResampleSubcell(taps, wx);
    }
    before[c] = ResampleSubcell(rows, wy);
  }
}

/// The filter over 4x4 taps.
/// \param load  takes a column and a row, -1..2, and a channel
template <typename Load>
HWY_INLINE void SampleTaps(bool spline, const PreviousPlace& place, const Load& load,
                           VF before[3]) {
  const DF d;
  VF wx[4];
  VF wy[4];
  if (spline) {
    CubicSpline(place.u, wx);
    CubicSpline(place.v, wy);
  } else {
    CatmullRom(place.u, wx);
    CatmullRom(place.v, wy);
  }
  for (int c = 0; c < 3; ++c) {
    before[c] = hn::Zero(d);
  }
  for (int j = 0; j < 4; ++j) {
    for (int c = 0; c < 3; ++c) {
      VF sum = hn::Mul(wx[0], load(-1, j - 1, c));
      for (int i = 1; i < 4; ++i) {
        sum = hn::MulAdd(wx[i], load(i - 1, j - 1, c), sum);
      }
      before[c] = hn::MulAdd(wy[j], sum, before[c]);
    }
  }
}

/// Gathers one value per lane; positions outside the image repeat its edge.
HWY_INLINE VF GatherClamped(const Image1& plane, VI x, VI y) {
  const DF d;
  const DI di;
  const VI stride = hn::Set(di, static_cast<int>(plane.stride()));
  const VI column = ClampColumns(x, plane.width());
  const VI row = ClampColumns(y, plane.height());
  return hn::GatherIndex(d, plane.Row(0), hn::Add(hn::Mul(row, stride), column));
}

/// An image of the last frame, and how it is resampled.
struct PreviousImage {
  const Image3& image;
  const Image3* spline;  ///< its spline coefficients; nullptr: not with a spline
  bool subcell;          ///< ResampleSubcell
};

/// The filter of an image over 4x4 taps. \param load  see SampleTaps
template <typename Load>
HWY_INLINE void FilterTaps(const PreviousImage& from, const PreviousPlace& place, const Load& load,
                           VF before[3]) {
  if (from.subcell) {
    SampleSubcell(place, load, before);
  } else {
    SampleTaps(from.spline != nullptr, place, load, before);
  }
}

/// Positions of a vector of pixels in the last frame.
struct PreviousPixels {
  PreviousPlace place;
  MF whole;          ///< the position is the centre of a pixel
  SideBySide block;  ///< the taps, if they are contiguous
};

/// \param inside  the valid lanes; others are not read
HWY_INLINE PreviousPixels FindPixels(VF px, VF py, MF inside) {
  const DF d;
  const DI di;
  const VF zero = hn::Zero(d);
  const VF sx = hn::IfThenElseZero(inside, px);
  const VF sy = hn::IfThenElseZero(inside, py);
  const VF fx = hn::Floor(sx);
  const VF fy = hn::Floor(sy);
  PreviousPixels at;
  at.place = {hn::ConvertTo(di, fx), hn::ConvertTo(di, fy), hn::Sub(sx, fx), hn::Sub(sy, fy)};
  at.whole = hn::And(hn::Eq(at.place.u, zero), hn::Eq(at.place.v, zero));
  at.block = FindSideBySide(at.place.x, at.place.y, inside);
  return at;
}

/// SamplePrevious for taps that are not contiguous, or outside the image.
HWY_NOINLINE inline void GatherPrevious(const PreviousImage& from, const PreviousPixels& at,
                                        VF before[3]) {
  const DI di;
  const Image3& taps = from.spline != nullptr ? *from.spline : from.image;
  FilterTaps(
      from, at.place,
      [&](int i, int j, int c) HWY_ATTR {
        return GatherClamped(taps[c], hn::Add(at.place.x, hn::Set(di, i)),
                             hn::Add(at.place.y, hn::Set(di, j)));
      },
      before);
  for (int c = 0; c < 3; ++c) {
    before[c] =
        hn::IfThenElse(at.whole, GatherClamped(from.image[c], at.place.x, at.place.y), before[c]);
  }
}

HWY_INLINE void SamplePrevious(const PreviousImage& from, const PreviousPixels& at, VF before[3]) {
  const DF d;
  const SideBySide& block = at.block;
  if (!LiesInPicture(block, 1, 2, from.image.width(), from.image.height())) {
    GatherPrevious(from, at, before);
    return;
  }
  if (hn::AllTrue(d, at.whole)) {  // no fractional offset
    for (int c = 0; c < 3; ++c) {
      before[c] = hn::LoadU(d, from.image[c].Row(block.y) + block.x);
    }
    return;
  }
  const Image3& taps = from.spline != nullptr ? *from.spline : from.image;
  const ptrdiff_t stride = taps[0].stride();
  const float* first[3];
  for (int c = 0; c < 3; ++c) {
    first[c] = taps[c].Row(block.y) + block.x;
  }
  FilterTaps(
      from, at.place,
      [&](int i, int j, int c) HWY_ATTR { return hn::LoadU(d, first[c] + j * stride + i); },
      before);
  if (!hn::AllFalse(d, at.whole)) {
    for (int c = 0; c < 3; ++c) {
      const VF kept = hn::LoadU(d, from.image[c].Row(block.y) + block.x);
      before[c] = hn::IfThenElse(at.whole, kept, before[c]);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
