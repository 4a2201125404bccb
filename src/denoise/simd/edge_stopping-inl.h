// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// SIMD versions of the weights in stages/edge_stopping_shared.h, with equal names. Exponents are of
// base 2 here.
#if defined(STILLRAY_DENOISE_SIMD_EDGE_STOPPING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_EDGE_STOPPING_INL_H_
#undef STILLRAY_DENOISE_SIMD_EDGE_STOPPING_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_EDGE_STOPPING_INL_H_
#endif

#include <algorithm>

#include "denoise/simd/normal_window.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/edge_stopping_shared.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Data of the centre pixels for the weights, loaded once per vector of pixels.
struct GuideCentre {
  VF nx, ny, nz;
  VF i;        ///< inverse depth
  VF gx, gy;   ///< its gradient
  VF z;        ///< depth (gradient weight)
  VF scale;    ///< log2(e) / (tolerance * i) (plane weight)
  VF flat;     ///< 0 where the slope is too steep for the gradient weight, else 1
  VF sigma_n;  ///< log2(e) CurvedSigmaN (Normals::kCurved)
};

/// The depth weight as a template argument: a branch in the innermost loop costs as much as a
/// formula.
enum class Depths {
  kGradient,
  kPlane,
  kEither,    ///< chosen by EdgeStopping::depth_weight_plane
  kPosition,  ///< see PositionCentre
};

/// How the normal weight is computed.
enum class Normals {
  kLogarithm,  ///< one exponent for all surfaces
  kCubic,      ///< one exponent, logarithm to third order; not chosen by NormalsOf
  kParabola,   ///< one exponent, logarithm to second order
  kCurved,     ///< CurvedSigmaN
};

/// From this exponent of the normal weight on, a parabola in the cosine replaces the logarithm
/// (weights differ by 1.1e-4 at 64, 2.8e-5 at 128).
constexpr float kParabolaFromSigmaN = 64;
HWY_INLINE Normals NormalsOf(const EdgeStopping& edges) {
  return edges.curvature > 0                    ? Normals::kCurved
         : edges.sigma_n >= kParabolaFromSigmaN ? Normals::kParabola
                                                : Normals::kLogarithm;
}

/// From this exponent on, a cubic replaces the logarithm, which needs a division, where every
/// neighbour has samples (weights differ by 2.9e-4 at 16). With few neighbours all weights may be
/// small; then their ratios count, which differ by more.
constexpr float kCubicFromSigmaN = 16;
HWY_INLINE Normals DenseNormalsOf(const EdgeStopping& edges) {
  const Normals normals = NormalsOf(edges);
  return normals == Normals::kLogarithm && edges.sigma_n >= kCubicFromSigmaN ? Normals::kCubic
                                                                             : normals;
}

template <Depths kDepths>
HWY_INLINE bool IsPlane(const EdgeStopping& e) {
  return kDepths == Depths::kEither ? e.depth_weight_plane != 0 : kDepths == Depths::kPlane;
}

/// The guides of one row.
struct GuideRow {
  const float* nx;
  const float* ny;
  const float* nz;
  const float* depth;  ///< inverse, or linear for the gradient weight
  const float* gx;
  const float* gy;
  const uint32_t* id;
  const float* turn2;  ///< nullptr: the normal weight ignores the turn
};

/// \param normals  of this row
template <Depths kDepths = Depths::kEither>
HWY_INLINE GuideRow GuideRowOf(const GuidePlanes& g, const NormalRows& normals,
                               const EdgeStopping& e, int y) {
  return {normals.x,
          normals.y,
          normals.z,
          (IsPlane<kDepths>(e) ? g.inverse_depth : g.depth).Row(y),
          g.gradient[0].Row(y),
          g.gradient[1].Row(y),
          g.id.Row(y),
          e.curvature > 0 ? g.turn2.Row(y) : nullptr};
}

/// \param least_sigma_n  see CurvedSigmaN
template <Depths kDepths = Depths::kEither>
HWY_INLINE GuideCentre LoadGuideCentre(const GuideRow& row, const EdgeStopping& e, int x,
                                       float least_sigma_n = kLeastCurvedSigmaN) {
  const DF d;
  GuideCentre c;
  c.nx = hn::LoadU(d, row.nx + x);
  c.ny = hn::LoadU(d, row.ny + x);
  c.nz = hn::LoadU(d, row.nz + x);
  c.gx = hn::LoadU(d, row.gx + x);
  c.gy = hn::LoadU(d, row.gy + x);
  // Each kind of depth weight reads only one plane of depths.
  const VF depth = hn::LoadU(d, row.depth + x);
  const VF one = hn::Set(d, 1.0f);
  const MF surface = hn::Gt(depth, hn::Zero(d));
  const VF inverse = hn::Div(one, hn::IfThenElse(surface, depth, one));
  const bool plane = IsPlane<kDepths>(e);
  c.i = plane ? depth : hn::IfThenElseZero(surface, inverse);
  c.z = plane ? inverse : hn::IfThenElse(surface, depth, one);
  c.scale = hn::Mul(c.z, hn::Set(d, kLog2E / e.plane_tolerance));
  c.flat = hn::Set(d, 1.0f);
  if (e.max_slope > 0) {
    const VF steep = hn::Mul(hn::Max(hn::Abs(c.gx), hn::Abs(c.gy)), c.z);
    c.flat = hn::IfThenZeroElse(hn::Gt(steep, hn::Set(d, e.max_slope)), c.flat);
  }
  c.sigma_n = hn::Zero(d);
  if (row.turn2 != nullptr) {
    const VF curved =
        hn::MulAdd(hn::Set(d, e.curvature * e.sigma_n), hn::LoadU(d, row.turn2 + x), one);
    const VF least = hn::Set(d, kLog2E * std::min(e.sigma_n, least_sigma_n));
    c.sigma_n = hn::Max(hn::Div(hn::Set(d, kLog2E * e.sigma_n), curved), least);
  }
  return c;
}

HWY_INLINE VF PlaneDeviation(const GuideCentre& c, VF iq, float dx, float dy) {
  const DF d;
  const VF expected = hn::MulAdd(c.gx, hn::Set(d, dx), hn::MulAdd(c.gy, hn::Set(d, dy), c.i));
  return hn::Abs(hn::Sub(expected, iq));
}

/// Data of the centre pixels for depth_weight=position.
struct PositionCentre {
  VF ray_x, ray_y;  ///< RayAt
  VF z, per_z;
  float per_focal;
  float scale;  ///< log2(e) / position_sigma^2
};

/// \param c  made with the depths of `row`, which are linear
HWY_INLINE PositionCentre LoadPositionCentre(const GuideCentre& c, const EdgeStopping& e, int x,
                                             int y) {
  const DF d;
  const float per_focal = 1 / e.focal_pixels;
  const VF from_left = hn::Add(hn::ConvertTo(d, ColumnNumbers(x)), hn::Set(d, 0.5f - e.centre_x));
  const float from_top = static_cast<float>(y) + 0.5f - e.centre_y;
  PositionCentre p;
  p.ray_x = hn::Mul(from_left, hn::Set(d, per_focal));
  p.ray_y = hn::Set(d, from_top * per_focal);
  p.z = c.z;
  p.per_z = hn::Div(hn::Set(d, 1.0f), c.z);
  p.per_focal = per_focal;
  p.scale = kLog2E / (e.position_sigma * e.position_sigma);
  return p;
}

/// PositionExponent of base 2 of a tap at depth zq; 0 is no surface.
HWY_INLINE VF PositionExponent(const PositionCentre& c, VF zq, float dx, float dy) {
  const DF d;
  const VF deeper = hn::Mul(hn::Sub(zq, c.z), c.per_z);
  const VF ratio = hn::Add(deeper, hn::Set(d, 1.0f));
  const VF across = hn::MulAdd(deeper, c.ray_x, hn::Mul(ratio, hn::Set(d, dx * c.per_focal)));
  const VF down = hn::MulAdd(deeper, c.ray_y, hn::Mul(ratio, hn::Set(d, dy * c.per_focal)));
  const VF distance2 = hn::MulAdd(across, across, hn::MulAdd(down, down, hn::Mul(deeper, deeper)));
  return hn::IfThenElse(hn::Gt(zq, hn::Zero(d)), hn::Mul(distance2, hn::Set(d, c.scale)),
                        hn::Set(d, kNeverSimilar));
}

/// log2(cosine^sigma_n); for cosines <= 0, of a tiny cosine.
HWY_INLINE VF NormalExponent(VF cosine, float sigma_n) {
  const DF d;
  return hn::Mul(hn::Set(d, sigma_n), Log2(hn::Max(cosine, hn::Set(d, 1e-30f))));
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
