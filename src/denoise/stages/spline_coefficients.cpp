// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/spline_coefficients.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/shared.h"
#include "denoise/row_scratch.h"
#include "denoise/stages/spline_coefficients_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/spline_coefficients.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// \param load  returns the vector at an offset of -kSplineRadius..kSplineRadius
template <typename Load>
HWY_INLINE VF Filter(const Load& load) {
  const DF d;
  static_assert(kSplineRadius == 4);
  VF sum = hn::Mul(hn::Set(d, kSplineWeight0), load(0));
  sum = hn::MulAdd(hn::Set(d, kSplineWeight1), hn::Add(load(-1), load(1)), sum);
  sum = hn::MulAdd(hn::Set(d, kSplineWeight2), hn::Add(load(-2), load(2)), sum);
  sum = hn::MulAdd(hn::Set(d, kSplineWeight3), hn::Add(load(-3), load(3)), sum);
  return hn::MulAdd(hn::Set(d, kSplineWeight4), hn::Add(load(-4), load(4)), sum);
}

void FilterRow(const Image1& picture, int y, float* column, Image1* out) {
  const DF d;
  const int width = picture.width();
  const float* rows[2 * kSplineRadius + 1];
  for (int k = -kSplineRadius; k <= kSplineRadius; ++k) {
    rows[k + kSplineRadius] = picture.Row(std::clamp(y + k, 0, picture.height() - 1));
  }
  for (int x = 0; x < width; x += LaneCount()) {
    const VF sum = Filter([&](int k) HWY_ATTR __attribute__((always_inline)) {
      return hn::LoadU(d, rows[k + kSplineRadius] + x);
    });
    hn::StoreU(sum, d, column + x);
  }
  std::fill_n(column - kSplineRadius, kSplineRadius, column[0]);
  std::fill_n(column + width, kSplineRadius, column[width - 1]);
  for (int x = 0; x < width; x += LaneCount()) {
    const VF sum = Filter([&](int k) HWY_ATTR
                          __attribute__((always_inline)) { return hn::LoadU(d, column + x + k); });
    StoreInRow(d, sum, out->Row(y), x, width);
  }
}

void SplineRows(const Image3& picture, int y0, int y1, Image3* out) {
  const RowScratch scratch(picture.width(), 1);
  for (int y = y0; y < y1; ++y) {
    for (int c = 0; c < 3; ++c) {
      FilterRow(picture[c], y, scratch.Row(0), &(*out)[c]);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(SplineRows);

void SplineCoefficients(const Image3& picture, Image3* out) {
  ParallelRows(picture.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(SplineRows)(picture, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
