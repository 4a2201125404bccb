// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Converts motion, depth and normals of other renderers to stillray's conventions.
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/parallel.h"
#include "stillray/aov.h"

namespace stillray {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Pixels per stored unit along an axis of `size` pixels.
float PixelsPerUnit(MotionUnit unit, int size) {
  switch (unit) {
    case MotionUnit::kPixels:
      return 1.0f;
    case MotionUnit::kFraction:
      return static_cast<float>(size);
    case MotionUnit::kNdc:
      return 0.5f * static_cast<float>(size);
  }
  return 1.0f;
}

/// Inverts a rasteriser's depth, 0 at near and 1 at far: d = (far / (far - near)) (1 - near / z).
/// In double precision, since most of the range is close to 1.
float LinearFromProjected(double d, double near, double far) {
  const double ratio = std::isinf(far) ? 0.0 : near / far;  // near / far
  const double scale = 1.0 - d * (1.0 - ratio);
  return scale > 0 && d < 1.0 ? static_cast<float>(near / scale) : kInfinity;
}

/// Inverts a rasteriser's reversed depth, 1 at near and 0 at far, where no digits cancel.
float LinearFromReversed(double d, double near, double far) {
  const double ratio = std::isinf(far) ? 0.0 : near / far;
  return d > 0 ? static_cast<float>(near / (d + (1.0 - d) * ratio)) : kInfinity;
}

/// Distance along the viewing axis of a point at `distance` from the camera.
/// \param dx, dy  pixels from the principal point
float LinearFromRay(float distance, float dx, float dy, float focal) {
  return distance / std::sqrt(1.0f + (dx * dx + dy * dy) / (focal * focal));
}

float LinearDepth(float stored, float dx, float dy, const DepthConvention& c) {
  if (std::isnan(stored)) {
    return stored;
  }
  switch (c.kind) {
    case DepthKind::kLinear:
      return stored >= c.background ? kInfinity : stored;
    case DepthKind::kRay:
      return stored >= c.background ? kInfinity : LinearFromRay(stored, dx, dy, c.focal);
    case DepthKind::kInverse:
      return stored == 0 ? kInfinity : 1.0f / stored;
    case DepthKind::kNormalised:
      return stored >= 1.0f ? kInfinity : c.near + stored * (c.far - c.near);
    case DepthKind::kProjected:
      return LinearFromProjected(stored, c.near, c.far);
    case DepthKind::kReversed:
      return LinearFromReversed(stored, c.near, c.far);
  }
  return stored;
}

std::array<float, 3> PermutedNormal(const std::array<float, 3>& stored, const NormalConvention& c) {
  std::array<float, 3> n;
  for (size_t i = 0; i < 3; ++i) {
    const int axis = c.axes[i];
    const float value = stored[static_cast<size_t>(std::abs(axis)) - 1];
    const float decoded = c.encoded ? 2.0f * value - 1.0f : value;
    n[i] = axis < 0 ? -decoded : decoded;
  }
  return n;
}

/// The transpose of a rotation is its inverse.
std::array<float, 3> ToWorld(const std::array<float, 3>& n, const std::array<float, 9>& m) {
  return {n[0] * m[0] + n[1] * m[1] + n[2] * m[2], n[0] * m[3] + n[1] * m[4] + n[2] * m[5],
          n[0] * m[6] + n[1] * m[7] + n[2] * m[8]};
}

std::array<float, 3> Unit(const std::array<float, 3>& n) {
  const float squared = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  // Encoded "no surface" is grey of 8 or 16 bits and decodes to almost zero.
  constexpr float kNoSurface = 1e-4f;
  if (squared < kNoSurface) {
    return {0, 0, 0};
  }
  const float scale = 1.0f / std::sqrt(squared);
  return {n[0] * scale, n[1] * scale, n[2] * scale};
}

}  // namespace

namespace {

/// \param sign  of the result relative to the stored values
Image2 ScaledMotion(const Image1& x, const Image1& y, const MotionConvention& c, float sign,
                    const JitterPair& jitter) {
  const int width = x.width();
  const int height = x.height();
  const float x_scale = sign * c.scale * PixelsPerUnit(c.unit, width);
  const float y_scale = sign * c.scale * PixelsPerUnit(c.unit, height) * (c.y_up ? -1.0f : 1.0f);
  // A point at p lies at p - jitter in the pixel grid.
  const float x_shift = c.jittered ? jitter.previous_x - jitter.x : 0.0f;
  const float y_shift = c.jittered ? jitter.previous_y - jitter.y : 0.0f;
  Image2 motion(width, height);
  ParallelRows(height, kRowsPerTask, [&](int y0, int y1) {
    for (int row = y0; row < y1; ++row) {
      for (int column = 0; column < width; ++column) {
        motion[0](column, row) = x(column, row) * x_scale + x_shift;
        motion[1](column, row) = y(column, row) * y_scale + y_shift;
      }
    }
  });
  return motion;
}

}  // namespace

Image2 ConvertMotion(const Image1& x, const Image1& y, const MotionConvention& c,
                     const JitterPair& jitter) {
  // Extrapolates steady motion.
  const bool as_stored =
      c.direction == MotionDirection::kToPrevious || c.direction == MotionDirection::kFromNext;
  return ScaledMotion(x, y, c, as_stored ? 1.0f : -1.0f, jitter);
}

Image2 ConvertNextMotion(const Image1& x, const Image1& y, const MotionConvention& c,
                         const JitterPair& jitter) {
  return ScaledMotion(x, y, c, c.direction == MotionDirection::kToNext ? 1.0f : -1.0f, jitter);
}

Image1 ConvertDepth(const Image1& depth, const DepthConvention& c) {
  Image1 linear(depth.width(), depth.height());
  const float middle_x = 0.5f * static_cast<float>(depth.width());
  const float middle_y = 0.5f * static_cast<float>(depth.height());
  ParallelRows(depth.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const float dy = static_cast<float>(y) + 0.5f - middle_y;
      for (int x = 0; x < depth.width(); ++x) {
        linear(x, y) = LinearDepth(depth(x, y), static_cast<float>(x) + 0.5f - middle_x, dy, c);
      }
    }
  });
  return linear;
}

Image1 ConvertHitDistance(const Image1& hits, const DepthConvention& c) {
  const bool zero_is_sky = c.kind == DepthKind::kInverse;
  Image1 linear = ConvertDepth(hits, c);
  ParallelRows(hits.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < hits.width(); ++x) {
        const float stored = hits(x, y);
        const bool is_known = stored > 0 || (zero_is_sky && stored == 0);
        linear(x, y) = is_known && linear(x, y) > 0 ? linear(x, y) : 0.0f;
      }
    }
  });
  return linear;
}

Image3 ConvertNormal(const Image3& normal, const NormalConvention& c,
                     const std::array<float, 9>* world_to_camera) {
  Image3 unit(normal.width(), normal.height());
  ParallelRows(normal.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < normal.width(); ++x) {
        std::array<float, 3> n =
            PermutedNormal({normal[0](x, y), normal[1](x, y), normal[2](x, y)}, c);
        if (c.camera_space && world_to_camera != nullptr) {
          n = ToWorld(n, *world_to_camera);
        }
        n = Unit(n);
        for (int i = 0; i < 3; ++i) {
          unit[i](x, y) = n[static_cast<size_t>(i)];
        }
      }
    }
  });
  return unit;
}

std::string ConventionText(const MotionConvention& c) {
  constexpr const char* kUnits[] = {"pixels", "fraction", "ndc"};
  constexpr const char* kDirections[] = {"to_previous", "from_previous", "to_next", "from_next"};
  std::string text =
      fmt::format("{}, {}, {}", kUnits[static_cast<size_t>(c.unit)],
                  kDirections[static_cast<size_t>(c.direction)], c.y_up ? "y_up" : "y_down");
  text += c.jittered ? ", jittered" : "";
  return c.scale == 1 ? text : text + fmt::format(", scale={}", c.scale);
}

std::string ConventionText(const DepthConvention& c) {
  constexpr const char* kKinds[] = {"linear",     "ray",       "inverse",
                                    "normalised", "projected", "reversed"};
  std::string text = kKinds[static_cast<size_t>(c.kind)];
  if (c.kind == DepthKind::kRay) {
    text += fmt::format(", focal={}", c.focal);
  }
  if (c.kind >= DepthKind::kNormalised) {
    text += fmt::format(", near={}, far={}", c.near, c.far);
  }
  return text;
}

std::string ConventionText(const NormalConvention& c) {
  std::string text =
      fmt::format("{}, {}", c.camera_space ? "camera" : "world", c.encoded ? "encoded" : "signed");
  if (c.axes != std::array<int, 3>{1, 2, 3}) {
    text += ", axes=";
    for (const int axis : c.axes) {
      text += axis < 0 ? "-" : "";
      text += "xyz"[std::abs(axis) - 1];
    }
  }
  return text;
}

}  // namespace stillray
