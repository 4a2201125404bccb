// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rows that are written past the caches: a stage's planes are larger than those, so what it writes
// is gone from them before the next stage reads it, and a plain store would first read the line
// that it overwrites (one signal of 1280x720 takes 0.88 of the time).
#if defined(STILLRAY_DENOISE_SIMD_STREAM_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_STREAM_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_STREAM_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_STREAM_ROWS_INL_H_
#endif

#include <hwy/cache_control.h>

#include "denoise/simd/next_row.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Only where a vector is a whole cache line: of parts of lines, a core holds fewer open than a
/// stage has planes.
constexpr bool kStreamsRows = hn::MaxLanes(DF()) * sizeof(float) == 64;

/// StoreInRow, past the caches. `row` is that of a plane, x a multiple of the lanes. FinishStreams
/// comes after the last one.
template <class D, class V, typename T>
HWY_INLINE void StreamInRow(D d, V v, T* row, int x, int width) {
  if constexpr (kStreamsRows) {
    if (width - x >= LaneCount()) {
      hn::Stream(v, d, row + x);
      return;
    }
  }
  StoreInRow(d, v, row, x, width);
}

/// Before other threads are told that the rows are there.
HWY_INLINE void FinishStreams() {
  if constexpr (kStreamsRows) {
    hwy::FlushStream();
  }
}

/// Adds what the next row will write with StreamInRow.
template <size_t kMost, class AnyPlane>
HWY_INLINE void AddStreamed(const AnyPlane& plane, int y, NextRow<kMost>* next) {
  if constexpr (!kStreamsRows) {
    next->Add(plane, y);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
