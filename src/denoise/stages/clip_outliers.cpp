// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/clip_outliers.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/clip_outliers.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Calls then(x offset, y) for the eight neighbours.
template <typename Then>
HWY_INLINE void ForEachNeighbour(int x, int y, const Then& then) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx != 0 || dy != 0) {
        then(x + dx, y + dy);
      }
    }
  }
}

struct Range {
  VF lowest, highest;
};

HWY_INLINE Range RangeOfNeighbours(const Image1& luminance, const Image1& where, int x, int y) {
  const DF d;
  const VF most = hn::Set(d, 1e37f);
  const VF least = hn::Neg(most);
  Range range = {most, least};
  ForEachNeighbour(
      x, y, [&](int qx, int qy) HWY_ATTR __attribute__((always_inline)) {
        const VF l = hn::LoadU(d, luminance.Row(qy) + qx);
        const MF there = hn::Gt(hn::LoadU(d, where.Row(qy) + qx), hn::Zero(d));
        range.lowest = hn::Min(range.lowest, hn::IfThenElse(there, l, most));
        range.highest = hn::Max(range.highest, hn::IfThenElse(there, l, least));
      });
  return range;
}

/// The light of outliers; anything elsewhere.
HWY_INLINE void StoreClipped(const LumaImage3& light, const Image1& where, const Range& range,
                             MF outlier, int x, int y, FilterPlanes* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = light.width();
  VF sum[3] = {zero, zero, zero};
  VF count = zero;
  ForEachNeighbour(
      x, y, [&](int qx, int qy) HWY_ATTR __attribute__((always_inline)) {
        const MF there = hn::Gt(hn::LoadU(d, where.Row(qy) + qx), zero);
        count = hn::Add(count, hn::IfThenElseZero(there, one));
        for (int c = 0; c < 3; ++c) {
          sum[c] = hn::Add(sum[c], hn::IfThenElseZero(there, hn::LoadU(d, light[c].Row(qy) + qx)));
        }
      });
  count = hn::Max(count, one);
  const VF l = hn::LoadU(d, light[0].Row(y) + x);
  const VF mean = hn::Div(sum[0], count);
  const MF lit = hn::Gt(mean, hn::Set(d, 1e-20f));
  const VF clipped = hn::Min(hn::Max(l, range.lowest), range.highest);
  const VF scale = hn::IfThenElse(lit, hn::Div(clipped, hn::IfThenElse(lit, mean, one)), one);
  for (int c = 0; c < 3; ++c) {
    StoreInRow(d, hn::Mul(hn::Div(sum[c], count), scale), out->colour[c].Row(y), x, width);
  }
  StoreInRow(d, hn::IfThenElseZero(outlier, one), out->variance.Row(y), x, width);
}

/// Finds outliers. `out` holds their light, its variance 1 at outliers and 0 at others; vectors
/// without outliers are marked by -1 at their first pixel and hold nothing.
void FindOutlierRows(const ClipOutliersInput& in, float most, const LumaImage3& light, int y0,
                     int y1, FilterPlanes* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF most2 = hn::Set(d, most * most);
  const int width = light.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF l = hn::LoadU(d, light[0].Row(y) + x);
      const MF there = hn::And(InRow(x, width), hn::Gt(hn::LoadU(d, in.where->Row(y) + x), zero));
      const Range range = RangeOfNeighbours(light[0], *in.where, x, y);
      const VF excess = hn::Max(hn::Sub(l, range.highest), hn::Sub(range.lowest, l));
      const VF noise = hn::Mul(most2, hn::LoadU(d, in.variance->Row(y) + x));
      const MF some = hn::Le(range.lowest, range.highest);
      const MF outlier =
          hn::And(hn::And(there, some),
                  hn::And(hn::Gt(excess, zero), hn::Le(hn::Mul(excess, excess), noise)));
      if (hn::AllFalse(d, outlier)) {
        out->variance.Row(y)[x] = -1;
      } else {
        StoreClipped(light, *in.where, range, outlier, x, y, out);
      }
    }
  }
}

void ReplaceRows(const FilterPlanes& clipped, int y0, int y1, LumaImage3* light) {
  const DF d;
  const int width = light->width();
  for (int y = y0; y < y1; ++y) {
    const float* marks = clipped.variance.Row(y);
    for (int x = 0; x < width; x += LaneCount()) {
      if (marks[x] < 0) {
        continue;
      }
      const MF outlier = hn::And(InRow(x, width), hn::Gt(hn::LoadU(d, marks + x), hn::Zero(d)));
      for (int c = 0; c < 3; ++c) {
        float* row = (*light)[c].Row(y);
        const VF value = hn::IfThenElse(outlier, hn::LoadU(d, clipped.colour[c].Row(y) + x),
                                        hn::LoadU(d, row + x));
        StoreInRow(d, value, row, x, width);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(FindOutlierRows);
HWY_EXPORT(ReplaceRows);

void ClipOutliers(const ClipOutliersInput& in, const ClipOutliersParameters& p,
                  FilterPlanes* scratch, LumaImage3* light) {
  ParallelRows(light->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FindOutlierRows)(in, p.clip_outliers, *light, y0, y1, scratch);
  });
  ParallelRows(light->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(ReplaceRows)(*scratch, y0, y1, light);
  });
}

}  // namespace stillray::cpu
#endif
