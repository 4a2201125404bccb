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

/// x, x + 1, ...: some compilers compute Highway's Iota lane by lane in memory, and the load of the
/// vector then waits for all stores.
alignas(64) constexpr int32_t kLaneNumbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                  8, 9, 10, 11, 12, 13, 14, 15};
HWY_INLINE VI ColumnNumbers(int x) {
  const DI di;
  static_assert(hn::MaxLanes(DI()) <= 16);
  return hn::Add(hn::Load(di, kLaneNumbers), hn::Set(di, x));
}

/// Number of lanes of a vector: the step of pixel loops.
HWY_INLINE int LaneCount() {
  return static_cast<int>(hn::Lanes(DF()));
}

/// A loaded value that is used more than once. GCC loads it again for each use, even with free
/// registers, and loads that cross a cache line are expensive.
HWY_INLINE VF InRegister(VF v) {
#if HWY_TARGET <= HWY_AVX3 && defined(__GNUC__)
  __asm__("" : "+v"(v.raw));
#endif
  return v;
}

/// Stores the lanes inside a row of `width` pixels; the border beyond is unchanged.
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

// 2^t as (u^2 + c)^2 + u with u = a t + b, up to a constant factor: the series of exp to the fourth
// power has this form, and takes three multiply-adds in place of four. a, b and c are minimax
// (relative error 1.4e-5); the factor is part of kWeightBias.
constexpr float kWeightExp2A = 0.346591952f;
constexpr float kWeightExp2C = 0.749961275f;
#if HWY_TARGET <= HWY_AVX3
constexpr float kWeightExp2B = 0.336709302f;  // for t in 0..1
constexpr float kWeightBias = -0.113755818f;
#else
constexpr float kWeightExp2B = 0.510002893f;  // for t in -1/2..1/2
constexpr float kWeightBias = -0.613748675f;
#endif

constexpr float kLeastWeight = kWeightBias - 60.0f;

HWY_INLINE VF WeightExp2Fraction(VF t) {
  const DF d;
  const VF u = hn::MulAdd(t, hn::Set(d, kWeightExp2A), hn::Set(d, kWeightExp2B));
  const VF v = hn::MulAdd(u, u, hn::Set(d, kWeightExp2C));
  return hn::MulAdd(v, v, u);
}

/// 2^(x - kWeightBias); callers add the bias to another constant of the exponent. 0 below 2^-60, or
/// with kTiny a value between 0 and that, for sums that it does not affect. Up to 2^100 the maximum
/// relative error is 1.5e-5 (tested), enough for weights. Computes two vectors in alternation: the
/// dependency chain of one is longer than the reorder window.
#if HWY_TARGET <= HWY_AVX3
// AVX-512 has instructions for x - floor(x) and for p 2^floor(x).
template <bool kTiny = false>
HWY_INLINE void WeightsExp2(const VF x[2], VF out[2]) {
  const DF d;
  constexpr int kBelow = 0x9;  // round down, keep no fraction bits, raise no exceptions
  for (int k = 0; k < 2; ++k) {
    const VF p = WeightExp2Fraction(VF{_mm512_reduce_ps(x[k].raw, kBelow)});
    if constexpr (kTiny) {
      // Masked with all lanes: compilers warn about undefined values in the unmasked form.
      out[k] = VF{_mm512_maskz_scalef_ps(__mmask16{0xffff}, p.raw, x[k].raw)};
    } else {
      const MF large = hn::Gt(x[k], hn::Set(d, kLeastWeight));
      out[k] = VF{_mm512_maskz_scalef_ps(large.raw, p.raw, x[k].raw)};
    }
  }
}

/// Flushes subnormal results to zero while an object exists: each would take about a hundred
/// cycles. For WeightsExp2 with kTiny.
class TinyIsZero {
 public:
  TinyIsZero() : before_(_mm_getcsr()) { _mm_setcsr(before_ | _MM_FLUSH_ZERO_ON); }
  ~TinyIsZero() { _mm_setcsr(before_); }
  TinyIsZero(const TinyIsZero&) = delete;
  TinyIsZero& operator=(const TinyIsZero&) = delete;

 private:
  unsigned before_;
};
#else
// Adding 1.5 * 2^23 leaves the rounded x in the low bits of the float, so that it can be shifted
// into the exponent without a conversion.
template <bool kTiny = false>
HWY_INLINE void WeightsExp2(const VF x[2], VF out[2]) {
  const DF d;
  const DI di;
  const VF large = hn::Set(d, 12582912.0f);  // 1.5 * 2^23
  const VF shifted0 = hn::Add(x[0], large);
  const VF shifted1 = hn::Add(x[1], large);
  const VF p0 = WeightExp2Fraction(hn::Sub(x[0], hn::Sub(shifted0, large)));
  const VF p1 = WeightExp2Fraction(hn::Sub(x[1], hn::Sub(shifted1, large)));
  const VI exponent0 = hn::ShiftLeft<23>(hn::BitCast(di, shifted0));
  const VI exponent1 = hn::ShiftLeft<23>(hn::BitCast(di, shifted1));
  const VF power0 = hn::BitCast(d, hn::Add(hn::BitCast(di, p0), exponent0));
  const VF power1 = hn::BitCast(d, hn::Add(hn::BitCast(di, p1), exponent1));
  const VF least = hn::Set(d, kLeastWeight);
  out[0] = hn::IfThenElseZero(hn::Gt(x[0], least), power0);
  out[1] = hn::IfThenElseZero(hn::Gt(x[1], least), power1);
}

/// No subnormal results here.
struct TinyIsZero {
  TinyIsZero() {}
};
#endif

/// 2^x of one vector, as WeightsExp2.
HWY_INLINE VF WeightExp2(VF x) {
  const VF biased = hn::Add(x, hn::Set(DF(), kWeightBias));
  const VF twice[2] = {biased, biased};  // the compiler removes one of them
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
  // The exponent, such that the mantissa is in sqrt(1/2)..sqrt(2).
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

/// The lanes that are pixels of the row.
HWY_INLINE MF InRow(int x, int width) {
  return hn::FirstN(DF(), static_cast<size_t>(width > x ? width - x : 0));
}

constexpr float kLog2E = 1.44269504f;

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
