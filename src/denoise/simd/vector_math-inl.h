// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Vector maths that several stages use. Included once per target, inside the per-target include
// guard.
#if defined(STILLRAY_DENOISE_SIMD_VECTOR_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_VECTOR_MATH_INL_H_
#undef STILLRAY_DENOISE_SIMD_VECTOR_MATH_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_VECTOR_MATH_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using VU = hn::Vec<DU>;
using MF = hn::Mask<DF>;

/// Minimax polynomial of 2^t for t in -1/2..1/2, relative, lowest power first.
constexpr float kWeightExp2[5] = {9.99999262e-01f, 6.93121818e-01f, 2.40247449e-01f,
                                  5.59178353e-02f, 9.57008570e-03f};
/// ... for t in 0..1.
constexpr float kWeightExp2Above[5] = {1.000002595f, 6.9300382e-01f, 2.4144278e-01f, 5.201147e-02f,
                                       1.353414e-02f};

/// x, x + 1, ...: Highway's Iota is worked out lane by lane by some compilers, and what reads the
/// vector then waits for all of their stores.
alignas(64) constexpr int32_t kLaneNumbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                  8, 9, 10, 11, 12, 13, 14, 15};
HWY_INLINE VI ColumnNumbers(int x) {
  const DI di;
  static_assert(hn::MaxLanes(DI()) <= 16);
  return hn::Add(hn::Load(di, kLaneNumbers), hn::Set(di, x));
}

/// Lanes of a vector as a step of pixel loops.
HWY_INLINE int LaneCount() {
  return static_cast<int>(hn::Lanes(DF()));
}

/// Stores the lanes that lie inside a row of `width` pixels; the border beyond it stays as it is.
template <class D, class V, typename T>
HWY_INLINE void StoreInRow(D d, V v, T* row, int x, int width) {
  const int left = width - x;
  if (left >= static_cast<int>(hn::Lanes(d))) {
    hn::StoreU(v, d, row + x);
  } else {
    hn::BlendedStore(v, hn::FirstN(d, static_cast<size_t>(left)), d, row + x);
  }
}

/// 2^x for x in -inf..126; 0 below -126. Maximum relative error 3e-7 (tested).
HWY_INLINE VF Exp2(VF x) {
  const DF d;
  const DI di;
  const VF clamped = hn::Max(x, hn::Set(d, -127.0f));
  const VF whole = hn::Round(clamped);
  const VF t = hn::Sub(clamped, whole);
  VF p = hn::Set(d, 1.5403530e-4f);
  p = hn::MulAdd(p, t, hn::Set(d, 1.3333558e-3f));
  p = hn::MulAdd(p, t, hn::Set(d, 9.6181291e-3f));
  p = hn::MulAdd(p, t, hn::Set(d, 5.5504109e-2f));
  p = hn::MulAdd(p, t, hn::Set(d, 2.4022651e-1f));
  p = hn::MulAdd(p, t, hn::Set(d, 6.9314718e-1f));
  p = hn::MulAdd(p, t, hn::Set(d, 1.0f));
  const VI scale = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, whole), hn::Set(di, 127)));
  return hn::Mul(p, hn::BitCast(d, scale));  // at -127 the scale is 0
}

/// 2^x; 0 below -60. For -60 <= x <= 100 the maximum relative error is 3e-6 (tested), enough for
/// weights. Two vectors, step by step: one alone is a longer chain than cores look ahead for
/// others.
#if HWY_TARGET <= HWY_AVX3
// AVX-512 has instructions for x - floor(x) and for p 2^floor(x).
HWY_INLINE void WeightsExp2(const VF x[2], VF out[2]) {
  const DF d;
  constexpr int kBelow = 0x9;  // round down, leave no bit of the fraction, raise nothing
  const VF least = hn::Set(d, -60.0f);
  for (int k = 0; k < 2; ++k) {
    const VF t{_mm512_reduce_ps(x[k].raw, kBelow)};
    VF p = hn::Set(d, kWeightExp2Above[4]);
    for (int i = 3; i >= 0; --i) {
      p = hn::MulAdd(p, t, hn::Set(d, kWeightExp2Above[i]));
    }
    out[k] = VF{_mm512_maskz_scalef_ps(hn::Gt(x[k], least).raw, p.raw, x[k].raw)};
  }
}
#else
// The rounded x stands in the low bits of a float that is too large for a fraction, so that it can
// be shifted into the exponent without conversion.
HWY_INLINE void WeightsExp2(const VF x[2], VF out[2]) {
  const DF d;
  const DI di;
  const VF large = hn::Set(d, 12582912.0f);  // 1.5 * 2^23
  const VF shifted0 = hn::Add(x[0], large);
  const VF shifted1 = hn::Add(x[1], large);
  const VF t0 = hn::Sub(x[0], hn::Sub(shifted0, large));
  const VF t1 = hn::Sub(x[1], hn::Sub(shifted1, large));
  VF p0 = hn::Set(d, kWeightExp2[4]);
  VF p1 = p0;
  for (int i = 3; i >= 0; --i) {
    const VF factor = hn::Set(d, kWeightExp2[i]);
    p0 = hn::MulAdd(p0, t0, factor);
    p1 = hn::MulAdd(p1, t1, factor);
  }
  const VI exponent0 = hn::ShiftLeft<23>(hn::BitCast(di, shifted0));
  const VI exponent1 = hn::ShiftLeft<23>(hn::BitCast(di, shifted1));
  const VF power0 = hn::BitCast(d, hn::Add(hn::BitCast(di, p0), exponent0));
  const VF power1 = hn::BitCast(d, hn::Add(hn::BitCast(di, p1), exponent1));
  const VF least = hn::Set(d, -60.0f);
  out[0] = hn::IfThenElseZero(hn::Gt(x[0], least), power0);
  out[1] = hn::IfThenElseZero(hn::Gt(x[1], least), power1);
}

#endif

/// Of one vector.
HWY_INLINE VF WeightExp2(VF x) {
  const VF twice[2] = {x, x};  // of which the compiler works out one
  VF out[2];
  WeightsExp2(twice, out);
  return out[0];
}

/// log2(x) for positive normal x. Maximum absolute error 1e-7 near 1, relative 2e-7 elsewhere
/// (tested).
HWY_INLINE VF Log2(VF x) {
  const DF d;
  const DI di;
  const VI bits = hn::BitCast(di, x);
  // The exponent that leaves a mantissa in sqrt(1/2)..sqrt(2).
  const VI exponent = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(di, 0x3f3504f3)));
  const VF m = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const VF one = hn::Set(d, 1.0f);
  const VF t = hn::Div(hn::Sub(m, one), hn::Add(m, one));
  const VF t2 = hn::Mul(t, t);
  VF p = hn::Set(d, 0.32059890f);  // 2 / (9 ln 2): the series of atanh, times 2 / ln 2
  p = hn::MulAdd(p, t2, hn::Set(d, 0.41219859f));
  p = hn::MulAdd(p, t2, hn::Set(d, 0.57707802f));
  p = hn::MulAdd(p, t2, hn::Set(d, 0.96179669f));
  p = hn::MulAdd(p, t2, hn::Set(d, 2.8853901f));
  return hn::MulAdd(p, t, hn::ConvertTo(d, exponent));
}

HWY_INLINE VF Luminance(VF r, VF g, VF b, bool rec601) {
  const DF d;
  const VF wr = hn::Set(d, rec601 ? 0.299f : 0.2126f);
  const VF wg = hn::Set(d, rec601 ? 0.587f : 0.7152f);
  const VF wb = hn::Set(d, rec601 ? 0.114f : 0.0722f);
  return hn::MulAdd(wr, r, hn::MulAdd(wg, g, hn::Mul(wb, b)));
}

/// Green709 and Green601.
HWY_INLINE VF Green(VF l, VF r, VF b, bool rec601) {
  const DF d;
  const VF wr = hn::Set(d, rec601 ? 0.299f : 0.2126f);
  const VF inverse_wg = hn::Set(d, rec601 ? 1 / 0.587f : 1 / 0.7152f);
  const VF wb = hn::Set(d, rec601 ? 0.114f : 0.0722f);
  const VF rest = hn::NegMulAdd(wr, r, hn::NegMulAdd(wb, b, l));
  return hn::Max(hn::Mul(rest, inverse_wg), hn::Zero(d));
}

/// |x| < infinity, false for NaN.
HWY_INLINE MF IsFiniteLane(VF x) {
  const DF d;
  return hn::Lt(hn::Abs(x), hn::Set(d, HUGE_VALF));
}

/// x, x + 1, ... as pixel coordinates.
HWY_INLINE VF ColumnsFrom(int x) {
  return hn::ConvertTo(DF(), ColumnNumbers(x));
}

/// Lanes of the row that are pixels.
HWY_INLINE MF InRow(int x, int width) {
  return hn::FirstN(DF(), static_cast<size_t>(width > x ? width - x : 0));
}

constexpr float kLog2E = 1.44269504f;

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
