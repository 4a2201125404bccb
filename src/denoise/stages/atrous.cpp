// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/atrous.h"

#include "core/check.h"
#include "core/parallel.h"
#include "denoise/planes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/atrous.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/edge_stopping-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// log2 of the kernel by distance from its centre.
constexpr float kLog2Kernel3[2] = {-1.0f, -2.0f};
constexpr float kLog2Kernel5[3] = {-1.41503750f, -2.0f, -4.0f};

struct Sums {
  VF r, g, b, variance, weight;
};

/// Rows of the taps at one vertical offset.
struct TapRows {
  const float* colour[3];
  const float* variance;
  const float* present;
  const float* normal[3];
  const float* inverse_depth;
  const uint32_t* id;
};

TapRows RowsAt(const FilterPlanes& in, const Image1& present, const GuidePlanes& g, int y) {
  return {{in.colour[0].Row(y), in.colour[1].Row(y), in.colour[2].Row(y)},
          in.variance.Row(y),
          present.Row(y),
          {g.normal[0].Row(y), g.normal[1].Row(y), g.normal[2].Row(y)},
          g.inverse_depth.Row(y),
          g.id.Row(y)};
}

HWY_INLINE void AddTap(const TapRows& q, int x, VF weight, VF r, VF g, VF b, Sums* sums) {
  const DF d;
  sums->r = hn::MulAdd(weight, r, sums->r);
  sums->g = hn::MulAdd(weight, g, sums->g);
  sums->b = hn::MulAdd(weight, b, sums->b);
  sums->variance =
      hn::MulAdd(hn::Mul(weight, weight), hn::LoadU(d, q.variance + x), sums->variance);
  sums->weight = hn::Add(sums->weight, weight);
}

/// Filters the pixels of one row. kWeights is a template argument so that each kind of filter has
/// an inner loop without branches.
template <AtrousWeights kWeights>
void FilterRow(const FilterPlanes& in, const Image1& spread, const Image1& present,
               const GuidePlanes& guides, const AtrousParameters& p, int y, FilterPlanes* out) {
  const DF d;
  const DU du;
  const int width = present.width();
  const float* log2_kernel = p.radius == 1 ? kLog2Kernel3 : kLog2Kernel5;
  TapRows rows[5];
  for (int j = -p.radius; j <= p.radius; ++j) {
    rows[j + p.radius] = RowsAt(in, present, guides, y + j * p.step);
  }
  const TapRows& own = rows[p.radius];
  const VF one = hn::Set(d, 1.0f);
  for (int x = 0; x < width; x += LaneCount()) {
    const GuideCentre c = LoadGuideCentre(guides, p.edges, x, y);
    const VF rp = hn::LoadU(d, own.colour[0] + x);
    const VF gp = hn::LoadU(d, own.colour[1] + x);
    const VF bp = hn::LoadU(d, own.colour[2] + x);
    const VF variance_p = hn::LoadU(d, own.variance + x);
    const VF present_p = hn::LoadU(d, own.present + x);
    const VF lp = Luminance(rp, gp, bp, p.rec601);
    const VU id_p = hn::LoadU(du, own.id + x);
    const VF spread_p = kWeights == AtrousWeights::kSvgf ? hn::LoadU(d, spread.Row(y) + x) : one;
    const VF ratio = hn::Set(d, p.noise_ratio);
    const VF eaw_l = hn::Mul(present_p, hn::Set(d, kLog2E / (p.eaw_sigma_l * p.eaw_sigma_l)));
    const VF eaw_n = hn::Set(d, kLog2E / (p.eaw_sigma_n * p.eaw_sigma_n));
    const VF eaw_z =
        hn::Mul(hn::Mul(c.z, c.z), hn::Set(d, kLog2E / (p.eaw_sigma_z * p.eaw_sigma_z)));
    Sums sums = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (int j = -p.radius; j <= p.radius; ++j) {
      const TapRows& q = rows[j + p.radius];
      const float dy = static_cast<float>(j * p.step);
      for (int i = -p.radius; i <= p.radius; ++i) {
        const int xq = x + i * p.step;
        const float log2_h = log2_kernel[i < 0 ? -i : i] + log2_kernel[j < 0 ? -j : j];
        const VF present_q = hn::LoadU(d, q.present + xq);
        const VF rq = hn::LoadU(d, q.colour[0] + xq);
        const VF gq = hn::LoadU(d, q.colour[1] + xq);
        const VF bq = hn::LoadU(d, q.colour[2] + xq);
        if (kWeights == AtrousWeights::kNaive || (i == 0 && j == 0)) {
          AddTap(q, xq, hn::Mul(present_q, Exp2(hn::Set(d, log2_h))), rq, gq, bq, &sums);
          continue;
        }
        const float dx = static_cast<float>(i * p.step);
        const VF nx = hn::LoadU(d, q.normal[0] + xq);
        const VF ny = hn::LoadU(d, q.normal[1] + xq);
        const VF nz = hn::LoadU(d, q.normal[2] + xq);
        const VF iq = hn::LoadU(d, q.inverse_depth + xq);
        VF exponent = hn::Set(d, log2_h);
        MF keep = hn::Gt(present_q, hn::Zero(d));
        if constexpr (kWeights == AtrousWeights::kEaw) {
          const VF ex = hn::Sub(c.nx, nx);
          const VF ey = hn::Sub(c.ny, ny);
          const VF ez = hn::Sub(c.nz, nz);
          const VF n2 = hn::MulAdd(ex, ex, hn::MulAdd(ey, ey, hn::Mul(ez, ez)));
          const VF deviation = PlaneDeviation(c, iq, dx, dy);
          const VF dl = hn::Sub(lp, Luminance(rq, gq, bq, p.rec601));
          exponent = hn::NegMulAdd(hn::Mul(dl, dl), eaw_l, exponent);
          exponent = hn::NegMulAdd(n2, eaw_n, exponent);
          exponent = hn::NegMulAdd(hn::Mul(deviation, deviation), eaw_z, exponent);
        } else {
          const VF cosine = hn::MulAdd(c.nx, nx, hn::MulAdd(c.ny, ny, hn::Mul(c.nz, nz)));
          keep = hn::And(keep, hn::Gt(cosine, hn::Zero(d)));
          exponent = hn::Add(exponent, NormalExponent(cosine, p.edges.sigma_n));
          exponent = hn::Sub(exponent, DepthExponent(c, p.edges, iq, dx, dy));
          if constexpr (kWeights == AtrousWeights::kSvgf) {
            const VF lq = Luminance(rq, gq, bq, p.rec601);
            VF noise = spread_p;
            if (p.noise_ratio > 1) {
              const VF spread_q = hn::LoadU(d, spread.Row(y + j * p.step) + xq);
              noise = hn::Max(spread_p, hn::Min(spread_q, hn::Mul(spread_p, ratio)));
            }
            const VF allowed = hn::MulAdd(hn::Set(d, p.sigma_l), noise, hn::Set(d, 1e-12f));
            const VF tolerance = hn::MulAdd(hn::Set(d, p.luminance_epsilon),
                                            hn::Max(hn::Abs(lp), hn::Abs(lq)), allowed);
            exponent = hn::NegMulAdd(hn::Div(hn::Abs(hn::Sub(lp, lq)), tolerance),
                                     hn::Set(d, kLog2E), exponent);
          }
        }
        if (p.test_id) {
          keep = hn::And(keep, hn::RebindMask(d, hn::Eq(id_p, hn::LoadU(du, q.id + xq))));
        }
        AddTap(q, xq, hn::IfThenElseZero(keep, Exp2(exponent)), rq, gq, bq, &sums);
      }
    }
    const MF filled =
        hn::And(hn::Gt(sums.weight, hn::Set(d, kMinAtrousWeight)), hn::Gt(c.i, hn::Zero(d)));
    const VF scale = hn::Div(one, hn::IfThenElse(filled, sums.weight, one));
    StoreInRow(d, hn::IfThenElse(filled, hn::Mul(sums.r, scale), rp), out->colour[0].Row(y), x,
               width);
    StoreInRow(d, hn::IfThenElse(filled, hn::Mul(sums.g, scale), gp), out->colour[1].Row(y), x,
               width);
    StoreInRow(d, hn::IfThenElse(filled, hn::Mul(sums.b, scale), bp), out->colour[2].Row(y), x,
               width);
    StoreInRow(d, hn::IfThenElse(filled, hn::Mul(sums.variance, hn::Mul(scale, scale)), variance_p),
               out->variance.Row(y), x, width);
    if (p.grown != nullptr) {
      StoreInRow(d, hn::IfThenElse(filled, one, present_p), p.grown->Row(y), x, width);
    }
  }
}

void AtrousRows(const FilterPlanes& in, const Image1& spread, const Image1& present,
                const GuidePlanes& guides, const AtrousParameters& p, int y0, int y1,
                FilterPlanes* out) {
  for (int y = y0; y < y1; ++y) {
    switch (p.weights) {
      case AtrousWeights::kNaive:
        FilterRow<AtrousWeights::kNaive>(in, spread, present, guides, p, y, out);
        break;
      case AtrousWeights::kGeometry:
        FilterRow<AtrousWeights::kGeometry>(in, spread, present, guides, p, y, out);
        break;
      case AtrousWeights::kSvgf:
        FilterRow<AtrousWeights::kSvgf>(in, spread, present, guides, p, y, out);
        break;
      case AtrousWeights::kEaw:
        FilterRow<AtrousWeights::kEaw>(in, spread, present, guides, p, y, out);
        break;
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(AtrousRows);

void Atrous(const FilterPlanes& in, const Image1& spread, const Image1& present,
            const GuidePlanes& guides, const AtrousParameters& p, FilterPlanes* out) {
  STILLRAY_CHECK_LE(p.step * p.radius, present.border());
  STILLRAY_CHECK_LE(p.step * p.radius, guides.inverse_depth.border());
  ParallelRows(present.height(), 8, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(AtrousRows)(in, spread, present, guides, p, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
