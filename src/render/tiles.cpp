// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/tiles.h"

#include <algorithm>

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace stillray::render {

Status ForEachTile(int width, int height, TileSize size, const RenderProgress& progress,
                   const std::function<void(const Tile&)>& body) {
  const int columns = (width + size.width - 1) / size.width;
  const int rows = (height + size.height - 1) / size.height;
  ProgressMeter meter(progress, static_cast<double>(columns) * rows);
  tbb::parallel_for(
      0, columns * rows, 1,
      [&](int i) {
        if (meter.cancelled()) {
          return;
        }
        Tile tile;
        tile.x0 = i % columns * size.width;
        tile.y0 = i / columns * size.height;
        tile.width = std::min(size.width, width - tile.x0);
        tile.height = std::min(size.height, height - tile.y0);
        {
          const DenormalsOff denormals_off;
          body(tile);
        }
        meter.Finish(1);
      },
      tbb::simple_partitioner());
  return meter.cancelled() ? Status::Cancelled() : Status::Ok();
}

void ProgressMeter::Finish(double work) {
  if (!progress_) {
    return;
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  done_ += work;
  if (!cancelled() && !progress_(std::min(done_ / total_, 1.0))) {
    cancelled_.store(true, std::memory_order_relaxed);
  }
}

#if defined(__SSE2__)
namespace {
/// Bits of MXCSR: flush to zero, denormals are zero.
constexpr unsigned kFlushToZero = 0x8000;
constexpr unsigned kDenormalsAreZero = 0x0040;
}  // namespace

DenormalsOff::DenormalsOff() : saved_(_mm_getcsr()) {
  _mm_setcsr(saved_ | kFlushToZero | kDenormalsAreZero);
}
DenormalsOff::~DenormalsOff() {
  _mm_setcsr(saved_);
}
#else
DenormalsOff::DenormalsOff() = default;
DenormalsOff::~DenormalsOff() = default;
#endif

}  // namespace stillray::render
