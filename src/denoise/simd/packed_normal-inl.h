// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Vectors of packed normals; mirrors packed_normal.h.
#if defined(STILLRAY_DENOISE_SIMD_PACKED_NORMAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_PACKED_NORMAL_INL_H_
#undef STILLRAY_DENOISE_SIMD_PACKED_NORMAL_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_PACKED_NORMAL_INL_H_
#endif

#include "denoise/packed_normal.h"
#include "denoise/planes.h"
#include "denoise/simd/normal_window.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// 1 or -1, with the sign of v; 1 at -0.
HWY_INLINE VF SignOf(VF v) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  return hn::IfThenElse(hn::Lt(v, hn::Zero(d)), hn::Neg(one), one);
}

HWY_INLINE VU PackNormal(const VF n[3]) {
  const DF d;
  const DI di;
  const DU du;
  const VF one = hn::Set(d, 1.0f);
  const VF sum = hn::Add(hn::Add(hn::Abs(n[0]), hn::Abs(n[1])), hn::Abs(n[2]));
  const MF given = hn::Gt(sum, hn::Zero(d));
  const VF scale = hn::Div(one, hn::IfThenElse(given, sum, one));
  const VF x = hn::Mul(n[0], scale);
  const VF y = hn::Mul(n[1], scale);
  const MF upper = hn::Ge(n[2], hn::Zero(d));
  const VF folded_x = hn::Mul(hn::Sub(one, hn::Abs(y)), SignOf(x));
  const VF folded_y = hn::Mul(hn::Sub(one, hn::Abs(x)), SignOf(y));
  const auto code = [&](VF c) HWY_ATTR {
    const VI steps = hn::NearestInt(hn::Mul(c, hn::Set(d, kNormalSteps)));
    return hn::BitCast(du, hn::Add(steps, hn::Set(di, static_cast<int>(kNormalZero))));
  };
  const VU packed = hn::Or(code(hn::IfThenElse(upper, x, folded_x)),
                           hn::ShiftLeft<16>(code(hn::IfThenElse(upper, y, folded_y))));
  return hn::IfThenElseZero(hn::RebindMask(du, given), packed);
}

/// Computes in quantization steps instead of fractions (normalisation removes the factor): values
/// are integers, without rounding until the last division.
HWY_INLINE void UnpackNormal(VU packed, VF n[3]) {
  const DF d;
  const DI di;
  const DU du;
  const auto steps = [&](VU code) HWY_ATTR {
    const VI centred = hn::Sub(hn::BitCast(di, code), hn::Set(di, static_cast<int>(kNormalZero)));
    return hn::ConvertTo(d, centred);
  };
  const VF ex = steps(hn::And(packed, hn::Set(du, 0xffffu)));
  const VF ey = steps(hn::ShiftRight<16>(packed));
  const VF z = hn::Sub(hn::Sub(hn::Set(d, kNormalSteps), hn::Abs(ex)), hn::Abs(ey));
  const VF fold = hn::Max(hn::Neg(z), hn::Zero(d));
  const VF x = hn::Sub(ex, hn::CopySign(fold, ex));
  const VF y = hn::Sub(ey, hn::CopySign(fold, ey));
  const VF length2 = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
  const MF given = hn::RebindMask(d, hn::Ne(packed, hn::Zero(du)));
  const VF scale = hn::IfThenElseZero(given, hn::Div(hn::Set(d, 1.0f), hn::Sqrt(length2)));
  n[0] = hn::Mul(x, scale);
  n[1] = hn::Mul(y, scale);
  n[2] = hn::Mul(z, scale);
}

/// The pixels begin..end of a row, and up to a vector more.
inline void UnpackNormals(const uint32_t* packed, int begin, int end, const NormalRowsTo& to) {
  const DF d;
  const DU du;
  for (int x = begin; x < end; x += LaneCount()) {
    VF n[3];
    UnpackNormal(hn::LoadU(du, packed + x), n);
    hn::StoreU(n[0], d, to.x + x);
    hn::StoreU(n[1], d, to.y + x);
    hn::StoreU(n[2], d, to.z + x);
  }
}

/// The normals of row y and of the rows around it that a neighbourhood reads: in the planes, or in
/// the window if the normals are packed.
inline NormalRows NormalsAround(const GuidePlanes& guides, int y, NormalWindow* window) {
  return guides.packs_normals() ? window->MoveTo(y, UnpackNormals) : NormalRowsOf(guides, y);
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
