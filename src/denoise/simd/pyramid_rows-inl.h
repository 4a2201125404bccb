// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rows of the pyramid of fill_guides, from one level to the next. The order of all sums is that of
// the scalar reference, so that both give the same bits.
#if defined(STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_
#endif

#include <algorithm>

#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/fill_guides_shared.h"
#include "stillray/image.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// The rows whose pixels are the children of one row of cells: three, fewer at the lower edge.
template <typename T>
struct ChildRows {
  const T* row[kPyramidFactor] = {};
  int count = 0;
};

template <typename T>
HWY_INLINE ChildRows<T> ChildrenOf(const Plane<T>& plane, int cell_y) {
  ChildRows<T> rows;
  const int first = cell_y * kPyramidFactor;
  rows.count = std::min(kPyramidFactor, plane.height() - first);
  for (int i = 0; i < rows.count; ++i) {
    rows.row[i] = plane.Row(first + i);
  }
  return rows;
}

/// Zeroes what threes of whole vectors read beyond the last column.
HWY_INLINE void ZeroBeyond(float* row, int width, int cells) {
  const int lanes = LaneCount();
  std::fill(row + width, row + kPyramidFactor * ((cells + lanes - 1) / lanes * lanes), 0.0f);
}

/// 1 where any of the nine children is known, and 1 over the number of those that are, or 0.
HWY_INLINE void RaiseMaskRow(const ChildRows<float>& masks, int width, int cells, float* sums,
                             float* known, float* inverse) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  for (int x = 0; x < width; x += LaneCount()) {
    VF sum = zero;
    for (int i = 0; i < masks.count; ++i) {
      sum = hn::Add(sum, hn::IfThenElseZero(hn::Gt(hn::LoadU(d, masks.row[i] + x), zero), one));
    }
    hn::StoreU(sum, d, sums + x);
  }
  ZeroBeyond(sums, width, cells);
  for (int x = 0; x < cells; x += LaneCount()) {
    VF a, b, c;
    hn::LoadInterleaved3(d, sums + kPyramidFactor * x, a, b, c);
    const VF count = hn::Add(hn::Add(a, b), c);
    const MF any = hn::Gt(count, zero);
    hn::StoreU(hn::IfThenElseZero(any, one), d, known + x);
    hn::StoreU(hn::IfThenElseZero(any, hn::Div(one, hn::Max(count, one))), d, inverse + x);
  }
}

/// Means of the known children; 0 where none is.
HWY_INLINE void RaiseRow(const ChildRows<float>& values, const ChildRows<float>& masks, int width,
                         const float* inverse, int cells, float* sums, float* above) {
  const DF d;
  const VF zero = hn::Zero(d);
  for (int x = 0; x < width; x += LaneCount()) {
    VF sum = zero;
    for (int i = 0; i < masks.count; ++i) {
      const MF known = hn::Gt(hn::LoadU(d, masks.row[i] + x), zero);
      sum = hn::Add(sum, hn::IfThenElseZero(known, hn::LoadU(d, values.row[i] + x)));
    }
    hn::StoreU(sum, d, sums + x);
  }
  ZeroBeyond(sums, width, cells);
  for (int x = 0; x < cells; x += LaneCount()) {
    VF a, b, c;
    hn::LoadInterleaved3(d, sums + kPyramidFactor * x, a, b, c);
    hn::StoreU(hn::Mul(hn::Add(hn::Add(a, b), c), hn::LoadU(d, inverse + x)), d, above + x);
  }
}

/// The first known child in reading order; 0 where none is.
HWY_INLINE void RaiseIdRow(const ChildRows<uint32_t>& ids, const ChildRows<float>& masks, int width,
                           int cells, uint32_t* above) {
  const DF d;
  const DU du;
  const VF zero = hn::Zero(d);
  const int whole = std::min(cells, width / kPyramidFactor) / LaneCount() * LaneCount();
  for (int x = 0; x < whole; x += LaneCount()) {
    VU first = hn::Zero(du);
    for (int i = masks.count - 1; i >= 0; --i) {
      VF m[kPyramidFactor];
      VU id[kPyramidFactor];
      hn::LoadInterleaved3(d, masks.row[i] + kPyramidFactor * x, m[0], m[1], m[2]);
      hn::LoadInterleaved3(du, ids.row[i] + kPyramidFactor * x, id[0], id[1], id[2]);
      for (int k = kPyramidFactor - 1; k >= 0; --k) {
        first = hn::IfThenElse(hn::RebindMask(du, hn::Gt(m[k], zero)), id[k], first);
      }
    }
    hn::StoreU(first, du, above + x);
  }
  for (int x = whole; x < cells; ++x) {
    above[x] = 0;
    for (int i = masks.count - 1; i >= 0; --i) {
      for (int q = std::min((x + 1) * kPyramidFactor, width) - 1; q >= x * kPyramidFactor; --q) {
        above[x] = masks.row[i][q] > 0 ? ids.row[i][q] : above[x];
      }
    }
  }
}

/// Row y of a level as the level above gives it, interpolated.
/// \param mixed  room for a row of cells, one more before and after it
HWY_INLINE void SpreadRow(const Image1& above, int y, float* mixed, float* out) {
  const DF d;
  const int cells = above.width();
  const float* row0 = above.Row(std::max(FirstParent(y), 0));
  const float* row1 = above.Row(std::min(FirstParent(y) + 1, above.height() - 1));
  const VF after = hn::Set(d, SecondParentWeight(y));
  const VF before = hn::Set(d, 1.0f - SecondParentWeight(y));
  for (int x = 0; x < cells; x += LaneCount()) {
    hn::StoreU(
        hn::Add(hn::Mul(hn::LoadU(d, row0 + x), before), hn::Mul(hn::LoadU(d, row1 + x), after)), d,
        mixed + x);
  }
  mixed[-1] = mixed[0];
  mixed[cells] = mixed[cells - 1];
  VF first_weight[kPyramidFactor];
  VF second_weight[kPyramidFactor];
  for (int k = 0; k < kPyramidFactor; ++k) {
    first_weight[k] = hn::Set(d, 1.0f - SecondParentWeight(k));
    second_weight[k] = hn::Set(d, SecondParentWeight(k));
  }
  for (int x = 0; x < cells; x += LaneCount()) {
    const VF left = hn::LoadU(d, mixed + x - 1);
    const VF own = hn::LoadU(d, mixed + x);
    const VF right = hn::LoadU(d, mixed + x + 1);
    hn::StoreInterleaved3(hn::Add(hn::Mul(left, first_weight[0]), hn::Mul(own, second_weight[0])),
                          hn::Add(hn::Mul(own, first_weight[1]), hn::Mul(right, second_weight[1])),
                          hn::Add(hn::Mul(own, first_weight[2]), hn::Mul(right, second_weight[2])),
                          d, out + kPyramidFactor * x);
  }
}

/// Row y of a level with the ids of the cells above.
HWY_INLINE void SpreadIdRow(const Plane<uint32_t>& above, int y, uint32_t* out) {
  const DU du;
  const uint32_t* row = above.Row(y / kPyramidFactor);
  for (int x = 0; x < above.width(); x += LaneCount()) {
    const VU id = hn::LoadU(du, row + x);
    hn::StoreInterleaved3(id, id, id, du, out + kPyramidFactor * x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
