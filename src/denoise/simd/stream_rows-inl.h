// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Non-temporal stores of rows. A stage's planes exceed the caches, so its results are evicted
// before the next stage reads them, and a plain store first reads the line that it overwrites
// (non-temporal stores reduce the time of one signal at 1280x720 to 0.88).
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

/// Used only if a vector is a whole cache line: cores have fewer write-combining buffers than a
/// stage has planes, so that partial lines would be flushed.
constexpr bool kStreamsRows = hn::MaxLanes(DF()) * sizeof(float) == 64;

/// StoreInRow with non-temporal stores. `row` is a row of a plane, x a multiple of the lanes. Call
/// FinishStreams after the last store.
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

/// Must be called before other threads may read the rows.
HWY_INLINE void FinishStreams() {
  if constexpr (kStreamsRows) {
    hwy::FlushStream();
  }
}

/// Adds the row that StreamInRow writes next, unless its stores bypass the caches.
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
