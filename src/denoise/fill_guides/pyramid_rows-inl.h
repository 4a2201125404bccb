// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rows of the pyramid of fill_guides, from one level to the next. Sums are in the order of the
// scalar reference, for bit-identical results.
#if defined(STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_PYRAMID_ROWS_INL_H_
#endif

#include <algorithm>

#include "denoise/fill_guides/fill_guides_shared.h"
#include "denoise/simd/vector_math-inl.h"
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

/// Zeroes the columns beyond `width` that loads of three whole SIMD vectors read.
HWY_INLINE void ZeroBeyond(float* row, int width, int cells) {
  const int lanes = LaneCount();
  std::fill(row + width, row + kPyramidFactor * ((cells + lanes - 1) / lanes * lanes), 0.0f);
}

/// Writes `known` = 1 where any of the nine children is known, else 0; `inverse` = 1 / their
/// number, or 0.
HWY_INLINE void DownsampleMaskRow(const ChildRows<float>& masks, int width, int cells, float* sums,
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

/// Means of the known children; 0 without any.
HWY_INLINE void DownsampleRow(const ChildRows<float>& values, const ChildRows<float>& masks,
                              int width, const float* inverse, int cells, float* sums,
                              float* above) {
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

/// The id of the first known child in row order; 0 without any.
HWY_INLINE void DownsampleIdRow(const ChildRows<uint32_t>& ids, const ChildRows<float>& masks,
                                int width, int cells, uint32_t* above) {
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

/// The level above, interpolated vertically at row y of the level below.
/// \param vertical  [out] a row of cells, with space for another cell before and after it
HWY_INLINE void UpsampleVertically(const Image1& above, int y, float* vertical) {
  const DF d;
  const int cells = above.width();
  const float* row0 = above.Row(std::max(FirstParent(y), 0));
  const float* row1 = above.Row(std::min(FirstParent(y) + 1, above.height() - 1));
  const VF after = hn::Set(d, SecondParentWeight(y));
  const VF before = hn::Set(d, 1.0f - SecondParentWeight(y));
  for (int x = 0; x < cells; x += LaneCount()) {
    hn::StoreU(
        hn::Add(hn::Mul(hn::LoadU(d, row0 + x), before), hn::Mul(hn::LoadU(d, row1 + x), after)), d,
        vertical + x);
  }
  vertical[-1] = vertical[0];
  vertical[cells] = vertical[cells - 1];
}

/// Horizontal interpolation: pixels from a row of cells a third as long.
class UpsampleAcross {
 public:
  UpsampleAcross() {
    for (int phase = 0; phase < kPyramidFactor; ++phase) {
      for (int lane = 0; lane < LaneCount(); ++lane) {
        const int pixel = phase + lane;
        const int part = pixel % kPyramidFactor;
        const int own = pixel / kPyramidFactor;
        own_[phase][lane] = own;
        // Plus one, since loads start at the previous cell.
        first_[phase][lane] = own + (part == 0 ? 0 : 1);
        first_weight_[phase][lane] = 1.0f - SecondParentWeight(part);
        second_weight_[phase][lane] = SecondParentWeight(part);
      }
    }
  }
  /// Interpolates the pixels x, x + 1, ... from a row of UpsampleVertically.
  HWY_INLINE VF operator()(const float* vertical, int x) const {
    const DF d;
    const int phase = x % kPyramidFactor;
    const float* cells = vertical + x / kPyramidFactor - 1;
    const VF first = Choose(d, cells, first_[phase]);
    const VF second = Choose(d, cells + 1, first_[phase]);
    return hn::Add(hn::Mul(first, hn::LoadU(d, first_weight_[phase])),
                   hn::Mul(second, hn::LoadU(d, second_weight_[phase])));
  }
  /// The values of the cells that cover the pixels x, x + 1, ...
  HWY_INLINE VU Own(const uint32_t* cells, int x) const {
    return Choose(DU(), cells + x / kPyramidFactor, own_[x % kPyramidFactor]);
  }

 private:
  static constexpr size_t kLanes = hn::MaxLanes(DF());

  template <class D, typename T>
  static HWY_INLINE hn::Vec<D> Choose(D d, const T* cells, const int32_t* index) {
    const VI at = hn::LoadU(DI(), index);
    if constexpr (kLanes == 1) {
      return hn::GatherIndex(d, cells, at);  // one lane has no neighbours to choose from
    } else {
      return hn::TableLookupLanes(hn::LoadU(d, cells), hn::IndicesFromVec(d, at));
    }
  }

  int32_t own_[kPyramidFactor][kLanes];
  int32_t first_[kPyramidFactor][kLanes];
  float first_weight_[kPyramidFactor][kLanes];
  float second_weight_[kPyramidFactor][kLanes];
};

/// Row y of a level, interpolated from the level above.
/// \param vertical  see UpsampleVertically
HWY_INLINE void UpsampleRow(const Image1& above, int y, float* vertical,
                            const UpsampleAcross& across, float* out) {
  UpsampleVertically(above, y, vertical);
  for (int x = 0; x < kPyramidFactor * above.width(); x += LaneCount()) {
    hn::StoreU(across(vertical, x), DF(), out + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
