// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Parallel loops on the thread pool of oneTBB, which the ray tracer uses too. The partition of
/// work into calls of `body` does not depend on the number of threads, so results do not either.
#pragma once

#include <functional>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace stillray {

/// Default number of image rows per task.
inline constexpr int kRowsPerTask = 16;

/// Calls body(y0, y1) for consecutive bands of at most `band` rows that cover 0..height.
template <typename Body>
void ParallelRows(int height, int band, const Body& body) {
  const int bands = (height + band - 1) / band;
  tbb::parallel_for(0, bands, [&](int i) {
    const int y0 = i * band;
    body(y0, y0 + band < height ? y0 + band : height);
  });
}

/// Reports progress, 0..1; return false to cancel, which then returns kCancelled. Called from any
/// thread, but never from two at once.
using ProgressCallback = std::function<bool(double fraction)>;

}  // namespace stillray
