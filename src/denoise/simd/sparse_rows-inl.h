// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rows of sparse frames: radiance of vectors without samples is not read.
#if defined(STILLRAY_DENOISE_SIMD_SPARSE_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_SPARSE_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_SPARSE_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_SPARSE_ROWS_INL_H_
#endif

#include "denoise/simd/vector_math-inl.h"
#include "stillray/image.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Whether none of the pixels x, x + 1, ... of a row has a sample.
HWY_INLINE bool NoSamples(const float* samples, int x, int width) {
  const DF d;
  const VF given = hn::LoadU(d, samples + x);
  return hn::AllTrue(d, hn::Or(hn::Eq(given, hn::Zero(d)), hn::Not(InRow(x, width))));
}
HWY_INLINE bool NoSamples(const Image1& samples, int x, int y) {
  return NoSamples(samples.Row(y), x, samples.width());
}

/// Whether less than one in eight pixels of a row has a sample.
HWY_INLINE bool IsSparseRow(const float* samples, int width) {
  const DF d;
  size_t with = 0;
  for (int x = 0; x < width; x += LaneCount()) {
    const MF some = hn::Ne(hn::LoadU(d, samples + x), hn::Zero(d));
    with += hn::CountTrue(d, hn::And(some, InRow(x, width)));
  }
  return 8 * with < static_cast<size_t>(width);
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
