// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "post/depth_of_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/parallel.h"
#include "post/guide_planes.h"
#include "post/layers.h"

namespace stillray::post {
namespace {

/// Number of pixels of a row that are gathered together, in a loop that compilers vectorise. The
/// last run of a row ends in the border.
constexpr int kRun = 32;
/// Side of the tiles with a known maximum radius.
constexpr int kTile = 32;

/// Planes with a border as wide as the maximum blur plus one run.
struct Taps {
  Image3 light;
  Image1 order;    ///< signed circle of confusion: grows with depth
  Image1 radius;   ///< of the disc, kSharpRadius or more
  Image1 density;  ///< 1 / area of the disc
};

/// The sum of Coverage(radius, .) over the plane.
float DiscArea(float radius) {
  return std::numbers::pi_v<float> * (radius * radius + 1.0f / 12.0f);
}

/// A sharp pixel has exactly one pixel's area.
float DensityOf(float radius) {
  return radius > kSharpRadius ? 1.0f / std::max(DiscArea(radius), 1.0f) : 1.0f;
}

Taps MakeTaps(const ThinLens& lens, const Image1& depth, const Image3& colour) {
  const int border = static_cast<int>(std::ceil(lens.max_radius)) + 1 + kRun;
  Taps taps;
  taps.light = FiniteLight(colour, border);
  for (Image1* plane : {&taps.order, &taps.radius, &taps.density}) {
    *plane = Image1(depth.width(), depth.height(), border);
  }
  constexpr int kBand = 16;
  ParallelRows(depth.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < depth.width(); ++x) {
        const float signed_radius = CircleOfConfusion(lens, depth(x, y));
        const float radius = std::clamp(std::abs(signed_radius), kSharpRadius, lens.max_radius);
        taps.order(x, y) = signed_radius;
        taps.radius(x, y) = radius;
        taps.density(x, y) = DensityOf(radius);
      }
    }
  });
  for (Image1* plane : {&taps.order, &taps.radius, &taps.density}) {
    FillBorder(plane);
  }
  return taps;
}

Image1 LargestOfTiles(const Image1& radius) {
  Image1 tiles((radius.width() + kTile - 1) / kTile, (radius.height() + kTile - 1) / kTile);
  for (int y = 0; y < radius.height(); ++y) {
    for (int x = 0; x < radius.width(); ++x) {
      float& tile = tiles(x / kTile, y / kTile);
      tile = std::max(tile, radius(x, y));
    }
  }
  return tiles;
}

/// The largest radius that reaches any pixel of a tile.
float ReachOfTile(const Image1& tiles, int tx, int ty, float max_radius) {
  const int ring = static_cast<int>(std::ceil((max_radius + 1.0f) / kTile));
  float reach = kSharpRadius;
  for (int y = std::max(ty - ring, 0); y <= std::min(ty + ring, tiles.height() - 1); ++y) {
    for (int x = std::max(tx - ring, 0); x <= std::min(tx + ring, tiles.width() - 1); ++x) {
      const int between = std::max({std::abs(x - tx), std::abs(y - ty), 1}) - 1;
      if (tiles(x, y) + 0.5f > static_cast<float>(between * kTile)) {
        reach = std::max(reach, tiles(x, y));
      }
    }
  }
  return reach;
}

/// Sums for the pixels of a run, by channel: weight, then radiance.
struct RunSums {
  using Row = std::array<float, kRun>;
  std::array<Row, 4> front = {};
  std::array<Row, 4> beside = {};
  std::array<Row, 4> behind = {};
  Row hidden = {};
};

/// Adds the taps at (dx, dy) from the run at (x0, y).
void AddTaps(const Taps& taps, int x0, int y, int dx, int dy, RunSums* __restrict sums) {
  const float distance = std::sqrt(static_cast<float>(dx * dx + dy * dy));
  const float* __restrict own_order = taps.order.Row(y) + x0;
  const float* __restrict own_radius = taps.radius.Row(y) + x0;
  const float* __restrict own_density = taps.density.Row(y) + x0;
  const float* __restrict order = taps.order.Row(y + dy) + x0 + dx;
  const float* __restrict radius = taps.radius.Row(y + dy) + x0 + dx;
  const float* __restrict density = taps.density.Row(y + dy) + x0 + dx;
  const float* __restrict red = taps.light[0].Row(y + dy) + x0 + dx;
  const float* __restrict green = taps.light[1].Row(y + dy) + x0 + dx;
  const float* __restrict blue = taps.light[2].Row(y + dy) + x0 + dx;
  for (int i = 0; i < kRun; ++i) {
    const float behind = order[i] - own_order[i];
    const Sides sides = SidesOf(behind);
    // Background does not reach further than the pixel's own blur.
    const float smaller = std::min(radius[i], own_radius[i]);
    const float denser = std::max(density[i], own_density[i]);
    const float reach = behind > 0.0f ? smaller : radius[i];
    const float spread = behind > 0.0f ? denser : density[i];
    const float covered = Coverage(reach, distance);
    const float own = Coverage(own_radius[i], distance);
    const float weight = covered * spread;
    const float front_weight = sides.front * weight;
    const float beside_weight = sides.beside * weight;
    const float behind_weight = sides.behind * own * own_density[i];
    const auto k = static_cast<size_t>(i);
    sums->front[0][k] += front_weight;
    sums->front[1][k] += front_weight * red[i];
    sums->front[2][k] += front_weight * green[i];
    sums->front[3][k] += front_weight * blue[i];
    sums->beside[0][k] += beside_weight;
    sums->beside[1][k] += beside_weight * red[i];
    sums->beside[2][k] += beside_weight * green[i];
    sums->beside[3][k] += beside_weight * blue[i];
    sums->behind[0][k] += behind_weight;
    sums->behind[1][k] += behind_weight * red[i];
    sums->behind[2][k] += behind_weight * green[i];
    sums->behind[3][k] += behind_weight * blue[i];
    sums->hidden[k] += sides.front * own_density[i] * std::max(own - covered, 0.0f);
  }
}

void GatherRun(const Taps& taps, int x0, int y, float reach, RunSums* sums) {
  const float end = reach + 0.5f;
  const int rows = static_cast<int>(end);
  for (int dy = -rows; dy <= rows; ++dy) {
    const int columns =
        static_cast<int>(std::sqrt(std::max(end * end - static_cast<float>(dy * dy), 0.0f)));
    for (int dx = -columns; dx <= columns; ++dx) {
      AddTaps(taps, x0, y, dx, dy, sums);
    }
  }
}

Layer LayerAt(const std::array<RunSums::Row, 4>& rows, size_t i) {
  return {rows[0][i], {rows[1][i], rows[2][i], rows[3][i]}};
}

void ComposeRun(const RunSums& sums, int x0, int y, int count, Image3* colour) {
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<size_t>(i);
    const LayerSums pixel = {LayerAt(sums.front, k), LayerAt(sums.beside, k),
                             LayerAt(sums.behind, k), sums.hidden[k]};
    const Sides shares = Shares(pixel);
    for (int c = 0; c < 3; ++c) {
      (*colour)[c](x0 + i, y) = Compose(pixel, shares, c);
    }
  }
}

Status CheckLens(const ThinLens& lens) {
  const auto bad = [](const char* name, float value, const char* expected) {
    return Status::InvalidArgument(fmt::format("{} is {}, expected {}", name, value, expected));
  };
  if (!(lens.radius >= 0.0f) || !std::isfinite(lens.radius)) {
    return bad("radius of the lens", lens.radius, "0 or above");
  }
  if (!(lens.focus > 0.0f)) {
    return bad("focus", lens.focus, "a depth above 0");
  }
  if (!(lens.pixels_per_tangent > 0.0f) || !std::isfinite(lens.pixels_per_tangent)) {
    return bad("pixels_per_tangent", lens.pixels_per_tangent, "above 0");
  }
  if (!(lens.max_radius >= kSharpRadius && lens.max_radius <= kLargestRadius)) {
    return bad("max_radius", lens.max_radius, "0.5 to 256");
  }
  return Status::Ok();
}

}  // namespace

float PixelsPerTangent(int height, double yfov) {
  return static_cast<float>(height / (2.0 * std::tan(0.5 * yfov)));
}

float CircleOfConfusion(const ThinLens& lens, float depth) {
  // Differences of radii determine the depth order: they must be finite.
  constexpr float kMost = 1e30f;
  const float tangents = lens.radius * (1.0f / lens.focus - InverseDepth(depth));
  const float pixels = tangents * lens.pixels_per_tangent;
  return std::isnan(pixels) ? 0.0f : std::clamp(pixels, -kMost, kMost);
}

Status DepthOfField(const ThinLens& lens, const Image1& depth, Image3* colour) {
  STILLRAY_RETURN_IF_ERROR(CheckLens(lens));
  STILLRAY_RETURN_IF_ERROR(CheckSize("depth", depth.width(), depth.height(), *colour));
  if (colour->empty()) {
    return Status::Ok();
  }
  const Taps taps = MakeTaps(lens, depth, *colour);
  const Image1 tiles = LargestOfTiles(taps.radius);
  constexpr int kBand = 4;
  ParallelRows(colour->height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < colour->width(); x += kRun) {
        const float reach = ReachOfTile(tiles, x / kTile, y / kTile, lens.max_radius);
        if (reach <= kSharpRadius) {
          continue;  // all neighbours are sharp
        }
        const int count = std::min(kRun, colour->width() - x);
        RunSums sums;
        GatherRun(taps, x, y, reach, &sums);
        ComposeRun(sums, x, y, count, colour);
      }
    }
  });
  return Status::Ok();
}

}  // namespace stillray::post
