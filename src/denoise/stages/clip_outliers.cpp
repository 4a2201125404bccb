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

/// The range of the eight neighbours, if all have samples.
HWY_INLINE Range RangeWithin(const Image1& luminance, int x, int y) {
  const DF d;
  const VF first = hn::LoadU(d, luminance.Row(y) + x - 1);
  Range range = {first, first};
  ForEachNeighbour(
      x, y, [&](int qx, int qy) HWY_ATTR __attribute__((always_inline)) {
        const VF l = hn::LoadU(d, luminance.Row(qy) + qx);
        range.lowest = hn::Min(range.lowest, l);
        range.highest = hn::Max(range.highest, l);
      });
  return range;
}

/// Whether all pixels of a block and their neighbours have samples.
bool IsFullAround(const Plane<uint32_t>* full, int block, int y) {
  uint32_t all = full != nullptr ? ~0u : 0u;
  for (int dy = -1; dy <= 1 && all != 0; ++dy) {
    const uint32_t* row = full->Row(y + dy) + block;
    all &= row[-1] & row[0] & row[1];
  }
  return all != 0;
}

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

/// Stores the new colour of outliers; other lanes have arbitrary values.
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

/// Finds outliers. `out` receives their new colour, and as variance 1 at outliers, else 0; vectors
/// without outliers have only the variance -1 at their first pixel.
void FindOutlierRows(const ClipOutliersInput& in, float most, const LumaImage3& light, int y0,
                     int y1, FilterPlanes* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF most2 = hn::Set(d, most * most);
  const VF least = hn::Set(d, kLeastOutlier);
  const int width = light.width();
  for (int y = y0; y < y1; ++y) {
    bool full = false;
    for (int x = 0; x < width; x += LaneCount()) {
      if (x % kBlockPixels == 0) {
        full = IsFullAround(in.full, x / kBlockPixels, y);
      }
      const VF l = hn::LoadU(d, light[0].Row(y) + x);
      const Range range =
          full ? RangeWithin(light[0], x, y) : RangeOfNeighbours(light[0], *in.where, x, y);
      const VF excess = hn::Max(hn::Sub(l, range.highest), hn::Sub(range.lowest, l));
      const VF noise = hn::Mul(most2, hn::LoadU(d, in.variance->Row(y) + x));
      MF outlier = hn::And(hn::Gt(excess, hn::Mul(least, hn::Max(hn::Max(l, range.highest), zero))),
                           hn::Le(hn::Mul(excess, excess), noise));
      if (!full) {
        const MF there = hn::And(InRow(x, width), hn::Gt(hn::LoadU(d, in.where->Row(y) + x), zero));
        outlier = hn::And(outlier, hn::And(there, hn::Le(range.lowest, range.highest)));
      }
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
