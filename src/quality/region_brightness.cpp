// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "core/parallel.h"
#include "quality/metrics.h"

namespace stillray::quality {
namespace {

constexpr int kMostPerSide = 8;  ///< regions
constexpr int kLeastSide = 16;   ///< pixels
/// Regions with a mean luminance below this fraction of the image's mean are excluded: their ratio
/// is not significant.
constexpr double kLeastLight = 0.01;

/// The regions of a grid over the image.
struct Grid {
  explicit Grid(const PicturePair& pair)
      : columns(std::clamp(pair.width() / kLeastSide, 1, kMostPerSide)),
        rows(std::clamp(pair.height() / kLeastSide, 1, kMostPerSide)) {}
  int columns;
  int rows;
};

/// Sums of luminance over a region's valid pixels.
struct Light {
  double test = 0;
  double reference = 0;
  int64_t pixels = 0;
};

Light LightOf(const PicturePair& pair, const Grid& grid, int column, int row) {
  Light light;
  for (int y = row * pair.height() / grid.rows; y < (row + 1) * pair.height() / grid.rows; ++y) {
    for (int x = column * pair.width() / grid.columns;
         x < (column + 1) * pair.width() / grid.columns; ++x) {
      if (pair.valid(x, y) != 0) {
        light.test += Luminance(pair.test, x, y);
        light.reference += Luminance(pair.reference, x, y);
        ++light.pixels;
      }
    }
  }
  return light;
}

}  // namespace

BrightnessRange RegionBrightness(const PicturePair& pair) {
  const Grid grid(pair);
  std::vector<Light> regions(static_cast<size_t>(grid.columns) * static_cast<size_t>(grid.rows));
  ParallelRows(grid.columns * grid.rows, 1, [&](int i, int) {
    regions[static_cast<size_t>(i)] = LightOf(pair, grid, i % grid.columns, i / grid.columns);
  });
  double sum = 0;
  for (const Light& region : regions) {
    sum += region.reference;
  }
  const double least = kLeastLight * sum / static_cast<double>(pair.valid_count);
  BrightnessRange range;
  bool any = false;
  for (const Light& region : regions) {
    if (region.reference > 0 && region.reference >= least * static_cast<double>(region.pixels)) {
      const double ratio = region.test / region.reference;
      range.lowest = any ? std::min(range.lowest, ratio) : ratio;
      range.highest = any ? std::max(range.highest, ratio) : ratio;
      any = true;
    }
  }
  return range;
}

}  // namespace stillray::quality
