// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <limits>

#include <fmt/core.h>

#include "quality/picture_pair.h"
#include "quality/row_sums.h"
#include "stillray/quality.h"

namespace stillray {
namespace {

/// Largest relative difference between the depth of a surface and that of its history.
constexpr double kDepthTolerance = 0.05;

struct Size {
  int width;
  int height;
};

Status CheckSize(const char* name, Size found, Size expected) {
  if (found.width == expected.width && found.height == expected.height) {
    return Status::Ok();
  }
  return Status::InvalidArgument(fmt::format("{} is {}x{} pixels, but the test picture is {}x{}",
                                             name, found.width, found.height, expected.width,
                                             expected.height));
}

template <typename T, int N>
Status CheckPlanes(const char* name, const Planes<T, N>& planes, Size expected) {
  for (int c = 0; c < N; ++c) {
    STILLRAY_RETURN_IF_ERROR(CheckSize(name, {planes[c].width(), planes[c].height()}, expected));
  }
  return Status::Ok();
}

/// The arguments of TemporalError.
struct Inputs {
  const Image3& test;
  const Image3& previous_test;
  const Image3& reference;
  const Image3& previous_reference;
  const Image2& motion;
  const Image1& depth;
  const Image1& previous_depth;
  bool display;

  Size size() const { return {test.width(), test.height()}; }
  bool has_depth() const { return !depth.empty() && !previous_depth.empty(); }

  Status Check() const {
    if (test.empty()) {
      return Status::InvalidArgument("the test picture is empty");
    }
    STILLRAY_RETURN_IF_ERROR(CheckPlanes("the test picture", test, size()));
    STILLRAY_RETURN_IF_ERROR(CheckPlanes("the previous test picture", previous_test, size()));
    STILLRAY_RETURN_IF_ERROR(CheckPlanes("the reference", reference, size()));
    STILLRAY_RETURN_IF_ERROR(CheckPlanes("the previous reference", previous_reference, size()));
    if (!motion.empty()) {
      STILLRAY_RETURN_IF_ERROR(CheckPlanes("the motion", motion, size()));
    }
    if (has_depth()) {
      STILLRAY_RETURN_IF_ERROR(CheckSize("the depth", {depth.width(), depth.height()}, size()));
      STILLRAY_RETURN_IF_ERROR(CheckSize(
          "the previous depth", {previous_depth.width(), previous_depth.height()}, size()));
    }
    return Status::Ok();
  }
};

/// The up to four pixels around a point and their bilinear weights.
struct Taps {
  struct Tap {
    int x = 0;
    int y = 0;
    double weight = 0;
  };
  std::array<Tap, 4> tap;
  bool inside = false;  ///< the point is inside the picture
};

/// \param x, y  relative to the centre of pixel (0,0)
Taps FindTaps(double x, double y, Size size) {
  Taps taps;
  // Also false for NaN.
  taps.inside = x >= -0.5 && y >= -0.5 && x <= size.width - 0.5 && y <= size.height - 0.5;
  if (!taps.inside) {
    return taps;
  }
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const double fx = x - x0;
  const double fy = y - y0;
  for (int i = 0; i < 4; ++i) {
    const int dx = i & 1;
    const int dy = i >> 1;
    taps.tap[static_cast<size_t>(i)] = {std::clamp(x0 + dx, 0, size.width - 1),
                                        std::clamp(y0 + dy, 0, size.height - 1),
                                        (dx != 0 ? fx : 1 - fx) * (dy != 0 ? fy : 1 - fy)};
  }
  return taps;
}

bool SameSurface(double depth, double previous_depth) {
  // Background is at infinity, where a relative tolerance accepts any depth.
  return depth == previous_depth || (std::isfinite(depth) && std::abs(previous_depth - depth) <=
                                                                 kDepthTolerance * std::abs(depth));
}

/// Whether any tap of the lookup shows a surface of this depth. False for NaN.
bool HistoryVisible(const Image1& previous_depth, const Taps& taps, double depth) {
  for (const Taps::Tap& tap : taps.tap) {
    if (tap.weight > 0 && SameSurface(depth, previous_depth(tap.x, tap.y))) {
      return true;
    }
  }
  return false;
}

/// A sum of absolute differences and their number.
struct ErrorSum {
  double sum = 0;
  int64_t values = 0;
};

/// Bilinear lookup of the plane's compressed values; NaN if a tap is not finite.
double Lookup(const Image1& plane, const Taps& taps, bool display) {
  double sum = 0;
  for (const Taps::Tap& tap : taps.tap) {
    if (tap.weight > 0) {
      const float value = plane(tap.x, tap.y);
      sum += std::isfinite(value) ? tap.weight * quality::CompressValue(value, display)
                                  : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return sum;
}

/// Adds one pixel's errors, unless one of its values or of its history is not finite.
void AddPixel(const Inputs& in, int x, int y, const Taps& taps, ErrorSum* total) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const float test = in.test[c](x, y);
    const float reference = in.reference[c](x, y);
    if (!std::isfinite(test) || !std::isfinite(reference)) {
      return;
    }
    const double test_change =
        quality::CompressValue(test, in.display) - Lookup(in.previous_test[c], taps, in.display);
    const double reference_change = quality::CompressValue(reference, in.display) -
                                    Lookup(in.previous_reference[c], taps, in.display);
    sum += std::abs(test_change - reference_change);
  }
  if (std::isfinite(sum)) {
    total->sum += sum;
    total->values += 3;
  }
}

ErrorSum SumOfRow(const Inputs& in, int y) {
  ErrorSum total;
  for (int x = 0; x < in.test.width(); ++x) {
    const double motion_x = in.motion.empty() ? 0.0 : in.motion[0](x, y);
    const double motion_y = in.motion.empty() ? 0.0 : in.motion[1](x, y);
    const Taps taps = FindTaps(x + motion_x, y + motion_y, in.size());
    if (taps.inside &&
        (!in.has_depth() || HistoryVisible(in.previous_depth, taps, in.depth(x, y)))) {
      AddPixel(in, x, y, taps, &total);
    }
  }
  return total;
}

}  // namespace

Result<double> TemporalError(const Image3& test, const Image3& previous_test,
                             const Image3& reference, const Image3& previous_reference,
                             const Image2& motion, const Image1& depth,
                             const Image1& previous_depth, bool display) {
  const Inputs inputs{test,   previous_test, reference,      previous_reference,
                      motion, depth,         previous_depth, display};
  STILLRAY_RETURN_IF_ERROR(inputs.Check());
  std::vector<int64_t> values(static_cast<size_t>(test.height()));
  const double sum = quality::SumRows(test.height(), [&](int y) {
    const ErrorSum row = SumOfRow(inputs, y);
    values[static_cast<size_t>(y)] = row.values;
    return row.sum;
  });
  const int64_t count = std::accumulate(values.begin(), values.end(), int64_t{0});
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace stillray
