// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "post/motion_blur.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/parallel.h"
#include "post/guide_planes.h"
#include "post/layers.h"

namespace stillray::post {
namespace {

constexpr int kTile = 16;
/// Surfaces whose depths differ by less than this fraction are ordered by motion too.
constexpr float kTouching = 0.02f;
/// Weight of motion in the depth order, for a static surface beside a moving one.
constexpr float kFaster = 2.0f;

struct Taps {
  Image3 light;
  Image2 half;     ///< half the path of a point, in pixels
  Image1 radius;   ///< its length, kSharpRadius or more
  Image1 inverse;  ///< 1 / depth
};

/// A line of taps.
struct Line {
  float x = 1;  ///< unit direction
  float y = 0;
  float radius = kSharpRadius;
};

Line LineOf(float half_x, float half_y, float radius) {
  return radius > kSharpRadius ? Line{half_x / radius, half_y / radius, radius} : Line{};
}

/// Sets half the path of the pixel's point.
void SetPath(const Shutter& shutter, const Image2& motion, int x, int y, Taps* taps) {
  const float mx = motion[0](x, y);
  const float my = motion[1](x, y);
  const float length = std::hypot(mx, my);
  const float diagonal =
      std::hypot(static_cast<float>(motion.width()), static_cast<float>(motion.height()));
  const float radius = 0.5f * shutter.open * length;
  const bool moves = length <= diagonal && radius > kSharpRadius;  // false for NaN
  const float shown = std::min(radius, shutter.max_radius);
  taps->half[0](x, y) = moves ? mx / length * shown : 0.0f;
  taps->half[1](x, y) = moves ? my / length * shown : 0.0f;
  taps->radius(x, y) = moves ? shown : kSharpRadius;
}

Taps MakeTaps(const Shutter& shutter, const Image2& motion, const Image1& depth,
              const Image3& colour) {
  constexpr int kBand = 16;
  Taps taps;
  taps.light = FiniteLight(colour, 0);
  taps.half = Image2(depth.width(), depth.height());
  taps.radius = Image1(depth.width(), depth.height());
  taps.inverse = Image1(depth.width(), depth.height());
  ParallelRows(depth.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < depth.width(); ++x) {
        SetPath(shutter, motion, x, y, &taps);
        taps.inverse(x, y) = InverseDepth(depth(x, y));
      }
    }
  });
  return taps;
}

/// The pixel with the longest path in each tile, as half path and length.
struct TileMotion {
  Image2 half;
  Image1 radius;
};

TileMotion LongestOfTiles(const Taps& taps) {
  const int width = taps.radius.width();
  const int height = taps.radius.height();
  const int columns = (width + kTile - 1) / kTile;
  const int rows = (height + kTile - 1) / kTile;
  TileMotion tiles = {Image2(columns, rows), Image1(columns, rows)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int tx = x / kTile;
      const int ty = y / kTile;
      if (taps.radius(x, y) > tiles.radius(tx, ty)) {
        tiles.radius(tx, ty) = taps.radius(x, y);
        tiles.half[0](tx, ty) = taps.half[0](x, y);
        tiles.half[1](tx, ty) = taps.half[1](x, y);
      }
    }
  }
  return tiles;
}

/// The longest path that reaches any pixel of a tile.
Line LineOfTile(const TileMotion& tiles, int tx, int ty, float max_radius) {
  const int ring = static_cast<int>(std::ceil((max_radius + 1.0f) / kTile));
  Line line;
  for (int y = std::max(ty - ring, 0); y <= std::min(ty + ring, tiles.radius.height() - 1); ++y) {
    for (int x = std::max(tx - ring, 0); x <= std::min(tx + ring, tiles.radius.width() - 1); ++x) {
      const int between = std::max({std::abs(x - tx), std::abs(y - ty), 1}) - 1;
      const float radius = tiles.radius(x, y);
      if (radius > line.radius && radius + 0.5f > static_cast<float>(between * kTile)) {
        line = LineOf(tiles.half[0](x, y), tiles.half[1](x, y), radius);
      }
    }
  }
  return line;
}

/// The filter of one pixel.
class PixelGather {
 public:
  PixelGather(const Taps& taps, int x, int y)
      : taps_(taps),
        x_(x),
        y_(y),
        radius_(taps.radius(x, y)),
        density_(0.5f / radius_),
        inverse_(taps.inverse(x, y)) {}

  /// The pixel's own surface and the background.
  void GatherOwn() {
    const Line line = LineOf(taps_.half[0](x_, y_), taps_.half[1](x_, y_), radius_);
    const int end = radius_ > kSharpRadius ? static_cast<int>(radius_ + 0.5f) : 0;
    for (int t = -end; t <= end; ++t) {
      AddOwn(TapAt(line, t));
    }
  }

  /// Surfaces in front that move across the pixel.
  void GatherFront(const Line& line) {
    const int end = static_cast<int>(line.radius + 0.5f);
    for (int t = -end; t <= end; ++t) {
      if (t != 0) {
        const Tap tap = TapAt(line, t);
        Add(tap, SidesOf(tap.order).front * tap.covered * tap.density, &sums_.front);
      }
    }
  }

  const LayerSums& sums() const { return sums_; }

 private:
  struct Tap {
    int x;
    int y;
    float order;     ///< > 0: behind the pixel
    float distance;  ///< from the pixel
    float radius;    ///< of its path along the line
    float density;
    float covered;  ///< coverage of the pixel by its path, 0..1
  };

  Tap TapAt(const Line& line, int t) const {
    Tap tap{};
    const auto along = static_cast<float>(t);
    tap.x = Inside(static_cast<int>(std::lround(static_cast<float>(x_) + along * line.x)),
                   taps_.radius.width());
    tap.y = Inside(static_cast<int>(std::lround(static_cast<float>(y_) + along * line.y)),
                   taps_.radius.height());
    tap.order = OrderOf(tap.x, tap.y);
    tap.distance = std::abs(along);
    const float half = taps_.half[0](tap.x, tap.y) * line.x + taps_.half[1](tap.x, tap.y) * line.y;
    tap.radius = std::max(std::abs(half), kSharpRadius);
    tap.density = 0.5f / tap.radius;
    tap.covered = Coverage(tap.radius, tap.distance);
    return tap;
  }

  static int Inside(int at, int size) { return std::clamp(at, 0, size - 1); }

  float OrderOf(int x, int y) const {
    const float inverse = taps_.inverse(x, y);
    const float nearer = std::max(inverse, inverse_);
    const float depth = nearer > 0.0f ? (inverse_ - inverse) / nearer / kTouching : 0.0f;
    const float radius = taps_.radius(x, y);
    return depth + kFaster * (radius_ - radius) / std::max(radius, radius_);
  }

  void AddOwn(const Tap& tap) {
    const Sides sides = SidesOf(tap.order);
    const bool behind = tap.order > 0.0f;
    const float own = Coverage(radius_, tap.distance);
    const float covered = behind ? std::min(tap.covered, own) : tap.covered;
    const float density = behind ? std::max(tap.density, density_) : tap.density;
    Add(tap, sides.beside * covered * density, &sums_.beside);
    Add(tap, sides.behind * own * density_, &sums_.behind);
    sums_.hidden += sides.front * density_ * std::max(own - covered, 0.0f);
  }

  void Add(const Tap& tap, float weight, Layer* layer) const {
    layer->weight += weight;
    for (int c = 0; c < 3; ++c) {
      layer->light[c] += weight * taps_.light[c](tap.x, tap.y);
    }
  }

  const Taps& taps_;
  int x_;
  int y_;
  float radius_;
  float density_;
  float inverse_;
  LayerSums sums_;
};

void BlurPixel(const Taps& taps, const Line& line, int x, int y, Image3* colour) {
  PixelGather gather(taps, x, y);
  gather.GatherOwn();
  gather.GatherFront(line);
  const Sides shares = Shares(gather.sums());
  for (int c = 0; c < 3; ++c) {
    (*colour)[c](x, y) = Compose(gather.sums(), shares, c);
  }
}

void BlurTile(const Taps& taps, const TileMotion& tiles, int tx, int ty, float max_radius,
              Image3* colour) {
  const Line line = LineOfTile(tiles, tx, ty, max_radius);
  if (line.radius <= kSharpRadius) {
    return;  // no neighbour moves
  }
  for (int y = ty * kTile; y < std::min((ty + 1) * kTile, colour->height()); ++y) {
    for (int x = tx * kTile; x < std::min((tx + 1) * kTile, colour->width()); ++x) {
      BlurPixel(taps, line, x, y, colour);
    }
  }
}

Status CheckShutter(const Shutter& shutter) {
  if (!(shutter.open >= 0.0f && shutter.open <= 1.0f)) {
    return Status::InvalidArgument(
        fmt::format("the shutter is open for {}, expected 0 to 1", shutter.open));
  }
  constexpr float kLargestRadius = 256;
  if (!(shutter.max_radius >= kSharpRadius && shutter.max_radius <= kLargestRadius)) {
    return Status::InvalidArgument(
        fmt::format("max_radius is {}, expected 0.5 to 256", shutter.max_radius));
  }
  return Status::Ok();
}

}  // namespace

Status MotionBlur(const Shutter& shutter, const Image2& motion, const Image1& depth,
                  Image3* colour) {
  STILLRAY_RETURN_IF_ERROR(CheckShutter(shutter));
  STILLRAY_RETURN_IF_ERROR(CheckSize("motion", motion.width(), motion.height(), *colour));
  STILLRAY_RETURN_IF_ERROR(CheckSize("depth", depth.width(), depth.height(), *colour));
  const Taps taps = MakeTaps(shutter, motion, depth, *colour);
  const TileMotion tiles = LongestOfTiles(taps);
  ParallelRows(tiles.radius.height(), 1, [&](int ty0, int ty1) {
    for (int ty = ty0; ty < ty1; ++ty) {
      for (int tx = 0; tx < tiles.radius.width(); ++tx) {
        BlurTile(taps, tiles, tx, ty, shutter.max_radius, colour);
      }
    }
  });
  return Status::Ok();
}

}  // namespace stillray::post
