// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Processes an image in tiles, on all threads, with progress and cancellation.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>

#include "stillray/render.h"

namespace stillray::render {

/// Pixels along a side of a tile, which fills one batch of rays.
inline constexpr int kTileSize = 32;

struct TileSize {
  int width = kTileSize;
  int height = kTileSize;
};

struct Tile {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;

  int count() const { return width * height; }
};

/// Calls body(tile) once for every tile of a width x height image, from several threads.
/// \param size  size of a tile; tiles at the right and lower edge of the image may be smaller
/// \return kCancelled if `progress` returned false; some tiles are then skipped
Status ForEachTile(int width, int height, TileSize size, const RenderProgress& progress,
                   const std::function<void(const Tile&)>& body);

/// Counts finished work units and calls the progress callback. Thread-safe.
class ProgressMeter {
 public:
  ProgressMeter(const RenderProgress& progress, double total)
      : progress_(progress), total_(total) {}

  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }
  void Finish(double work);

 private:
  const RenderProgress& progress_;
  double total_;
  std::mutex mutex_;
  double done_ = 0;
  std::atomic<bool> cancelled_{false};
};

/// Treats denormal numbers as zero on this thread during its lifetime: they would slow Embree down.
class DenormalsOff {
 public:
  DenormalsOff();
  ~DenormalsOff();
  DenormalsOff(const DenormalsOff&) = delete;
  DenormalsOff& operator=(const DenormalsOff&) = delete;

 private:
  unsigned saved_ = 0;
};

}  // namespace stillray::render
