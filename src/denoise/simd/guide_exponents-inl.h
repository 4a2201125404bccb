// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Geometry weights of the taps of a neighbourhood, as exponents of 2.
#if defined(STILLRAY_DENOISE_SIMD_GUIDE_EXPONENTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_GUIDE_EXPONENTS_INL_H_
#undef STILLRAY_DENOISE_SIMD_GUIDE_EXPONENTS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_GUIDE_EXPONENTS_INL_H_
#endif

#include <utility>

#include "denoise/planes.h"
#include "denoise/simd/edge_stopping-inl.h"
#include "denoise/simd/tap_pairs.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// sigma_n log2(cosine), to second order about 1. Far from 1 the weight is 0 in any case.
HWY_INLINE VF NearParabola(VF cosine, VF bias, float sigma_n) {
  const DF d;
  const float k = sigma_n * kLog2E;
  return hn::MulAdd(cosine, hn::MulAdd(cosine, hn::Set(d, -0.5f * k), hn::Set(d, 2.0f * k)), bias);
}
constexpr float kParabolaAtZero = -1.5f * kLog2E;

/// sigma_n log2(cosine), to third order.
HWY_INLINE VF NearCubic(VF cosine, VF bias, float sigma_n) {
  const DF d;
  const float k = sigma_n * kLog2E;
  const VF curved = hn::MulAdd(cosine, hn::Set(d, k / 3), hn::Set(d, -1.5f * k));
  return hn::MulAdd(cosine, hn::MulAdd(cosine, curved, hn::Set(d, 3.0f * k)), bias);
}
constexpr float kCubicAtZero = -11.0f / 6 * kLog2E;

HWY_INLINE VF LogCosine(VF cosine) {
  const DF d;
  return hn::MulAdd(cosine, hn::NegMulAdd(cosine, hn::Set(d, 0.5f), hn::Set(d, 2.0f)),
                    hn::Set(d, -1.5f));
}

/// Exponent of the normal weight at one tap, plus the bias.
/// \param q  index of the tap in the rows of normals
template <Normals kNormals>
HWY_INLINE VF NormalExponentAt(const GuideRow& g, const GuideCentre& c, ptrdiff_t q, VF bias,
                               float sigma_n) {
  const DF d;
  const VF cosine =
      hn::MulAdd(c.nx, hn::LoadU(d, g.nx + q),
                 hn::MulAdd(c.ny, hn::LoadU(d, g.ny + q), hn::Mul(c.nz, hn::LoadU(d, g.nz + q))));
  VF exponent;
  if constexpr (kNormals == Normals::kCurved) {
    exponent = hn::MulAdd(c.sigma_n, LogCosine(cosine), bias);
  } else if constexpr (kNormals == Normals::kParabola) {
    exponent = NearParabola(cosine, bias, sigma_n);
  } else if constexpr (kNormals == Normals::kCubic) {
    exponent = NearCubic(cosine, bias, sigma_n);
  } else {
    exponent = hn::Add(bias, NormalExponent(cosine, sigma_n));
    exponent = hn::IfThenElse(hn::Gt(cosine, hn::Zero(d)), exponent, hn::Set(d, -1000.0f));
  }
  return exponent;
}

/// Exponent of the geometry weights at one tap; `expected` is the depth of the centre's plane at
/// the tap.
/// \param normal_q  index of the tap in the rows of normals
template <Normals kNormals>
HWY_INLINE VF GuideExponent(const GuideRow& g, const GuideCentre& c, ptrdiff_t q,
                            ptrdiff_t normal_q, VF expected, VF depth_scale, VF bias,
                            float sigma_n) {
  const DF d;
  const VF exponent = NormalExponentAt<kNormals>(g, c, normal_q, bias, sigma_n);
  const VF deviation = hn::Abs(hn::Sub(expected, hn::LoadU(d, g.depth + q)));
  return hn::NegMulAdd(deviation, depth_scale, exponent);
}

/// Exponents (including kWeightBias) or weights of all taps of one vector of pixels, in the order
/// of the pairs.
using TapVectors = float[2 * TapPairs::kMost][hn::MaxLanes(DF())];

/// Destination of the exponents.
struct TapSlots {
  float* first;
  ptrdiff_t stride;  ///< between taps
};

HWY_INLINE TapSlots SlotsOf(TapVectors& taps) {
  return {taps[0], hn::MaxLanes(DF())};
}

/// Calls `body` with the number of each pair.
/// \tparam kPairs  number of pairs; small numbers are unrolled. 0: `taps.count`
template <int kPairs, typename Body>
HWY_INLINE void ForEachPair(const TapPairs& taps, const Body& body) {
  if constexpr (kPairs > 0 && kPairs <= 4) {
    const auto unrolled = [&]<int... kPair>(std::integer_sequence<int, kPair...>) HWY_ATTR
        __attribute__((always_inline)) {
      (body(kPair), ...);
    };
    unrolled(std::make_integer_sequence<int, kPairs>());
  } else {
    const int count = kPairs > 0 ? kPairs : taps.count;
    for (int i = 0; i < count; ++i) {
      body(i);
    }
  }
}

/// The pairs, with all constant terms of the exponent added to the kernel's logarithm.
HWY_INLINE TapPairs WithBias(TapPairs taps, const EdgeStopping& edges, Normals normals) {
  const float at_zero = normals == Normals::kParabola ? kParabolaAtZero
                        : normals == Normals::kCubic  ? kCubicAtZero
                                                      : 0.0f;
  const float bias = kWeightBias + edges.sigma_n * at_zero;
  for (int i = 0; i < taps.count; ++i) {
    taps.pair[i].log2_kernel += bias;
  }
  return taps;
}

/// Exponents of the geometry weights at the taps of the pixels x, x + 1, ..., shared by all
/// signals. This is a separate pass because the dependency chain from the guides to the sums
/// exceeds the reorder window of cores.
/// \tparam kWeights  stores weights instead of exponents
/// \param taps  made by WithBias
template <Normals kNormals, Depths kDepths = Depths::kEither, int kPairs = 0, bool kWeights = false>
HWY_INLINE void GuideExponents(const TapPairs& taps, const EdgeStopping& edges, bool test_id,
                               const GuideRow& guide, const GuideCentre& c, int x, TapSlots to) {
  const DF d;
  const DU du;
  const VF slope_scale = hn::Mul(hn::Set(d, edges.sigma_z), hn::Mul(c.z, c.z));
  const VF slope_least = hn::Mul(hn::Set(d, edges.depth_epsilon), c.z);
  const VF steepness = hn::Mul(c.flat, hn::Set(d, kLog2E));
  const VU id = test_id ? hn::LoadU(du, guide.id + x) : hn::Zero(du);
  ForEachPair<kPairs>(
      taps, [&](int i) HWY_ATTR __attribute__((always_inline)) {
        const TapPair& pair = taps.pair[i];
        const VF bias = hn::Set(d, pair.log2_kernel);
        const VF along = hn::MulAdd(c.gx, hn::Set(d, pair.dx), hn::Mul(c.gy, hn::Set(d, pair.dy)));
        VF expected[2];
        VF scale;
        if (IsPlane<kDepths>(edges)) {
          expected[0] = hn::Add(c.i, along);
          expected[1] = hn::Sub(c.i, along);
          scale = c.scale;
        } else {
          expected[0] = expected[1] = c.z;
          scale = hn::Div(steepness, hn::MulAdd(slope_scale, hn::Abs(along), slope_least));
        }
        VF exponent[2];
        for (int side = 0; side < 2; ++side) {
          const ptrdiff_t q = x + (side == 0 ? pair.distance : -pair.distance);
          const ptrdiff_t normal_q = x + (side == 0 ? pair.normal_distance : -pair.normal_distance);
          exponent[side] = GuideExponent<kNormals>(guide, c, q, normal_q, expected[side], scale,
                                                   bias, edges.sigma_n);
          if (test_id) {
            const MF same = hn::RebindMask(d, hn::Eq(id, hn::LoadU(du, guide.id + q)));
            exponent[side] = hn::IfThenElse(same, exponent[side], hn::Set(d, -1000.0f));
          }
        }
        if constexpr (kWeights) {
          VF weight[2];
          WeightsExp2(exponent, weight);
          exponent[0] = weight[0];
          exponent[1] = weight[1];
        }
        hn::Store(exponent[0], d, to.first + 2 * i * to.stride);
        hn::Store(exponent[1], d, to.first + (2 * i + 1) * to.stride);
      });
}

/// GuideExponents with the position weight in place of the depth weight.
template <Normals kNormals>
HWY_INLINE void PositionExponents(const TapPairs& taps, const EdgeStopping& edges, bool test_id,
                                  const GuideRow& guide, const GuideCentre& c, int x, int y,
                                  TapSlots to) {
  const DF d;
  const DU du;
  const PositionCentre position = LoadPositionCentre(c, edges, x, y);
  const VU id = test_id ? hn::LoadU(du, guide.id + x) : hn::Zero(du);
  for (int i = 0; i < taps.count; ++i) {
    const TapPair& pair = taps.pair[i];
    const VF bias = hn::Set(d, pair.log2_kernel);
    for (int side = 0; side < 2; ++side) {
      const float sign = side == 0 ? 1.0f : -1.0f;
      const ptrdiff_t q = x + (side == 0 ? pair.distance : -pair.distance);
      const ptrdiff_t normal_q = x + (side == 0 ? pair.normal_distance : -pair.normal_distance);
      VF exponent = NormalExponentAt<kNormals>(guide, c, normal_q, bias, edges.sigma_n);
      exponent = hn::Sub(exponent, PositionExponent(position, hn::LoadU(d, guide.depth + q),
                                                    sign * pair.dx, sign * pair.dy));
      if (test_id) {
        const MF same = hn::RebindMask(d, hn::Eq(id, hn::LoadU(du, guide.id + q)));
        exponent = hn::IfThenElse(same, exponent, hn::Set(d, -1000.0f));
      }
      hn::Store(exponent, d, to.first + (2 * i + side) * to.stride);
    }
  }
}

/// PositionExponents with the kind of normal weight that `edges` selects.
HWY_INLINE void PositionExponents(const TapPairs& taps, const EdgeStopping& edges, bool test_id,
                                  const GuideRow& guide, const GuideCentre& c, int x, int y,
                                  TapSlots to) {
  switch (NormalsOf(edges)) {
    case Normals::kLogarithm:
    case Normals::kCubic:
      PositionExponents<Normals::kLogarithm>(taps, edges, test_id, guide, c, x, y, to);
      break;
    case Normals::kParabola:
      PositionExponents<Normals::kParabola>(taps, edges, test_id, guide, c, x, y, to);
      break;
    case Normals::kCurved:
      PositionExponents<Normals::kCurved>(taps, edges, test_id, guide, c, x, y, to);
      break;
  }
}

/// Converts exponents to weights.
template <int kPairs = 0>
HWY_INLINE void WeightsOfExponents(const TapPairs& taps, TapSlots exponents) {
  const DF d;
  ForEachPair<kPairs>(
      taps, [&](int i) HWY_ATTR __attribute__((always_inline)) {
        float* first = exponents.first + 2 * i * exponents.stride;
        float* second = first + exponents.stride;
        const VF exponent[2] = {hn::Load(d, first), hn::Load(d, second)};
        VF weight[2];
        WeightsExp2(exponent, weight);
        hn::Store(weight[0], d, first);
        hn::Store(weight[1], d, second);
      });
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
