// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/history.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace stillray::quality {
namespace {

/// Maximum relative difference between the depth of a surface and of its history.
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

/// \param x, y  relative to the centre of pixel (0,0)
HistoryTaps FindTaps(double x, double y, Size size) {
  HistoryTaps taps;
  // Also false for NaN.
  taps.visible = x >= -0.5 && y >= -0.5 && x <= size.width - 0.5 && y <= size.height - 0.5;
  if (!taps.visible) {
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
  // Background is at infinity, where any depth is within a relative tolerance.
  return depth == previous_depth || (std::isfinite(depth) && std::abs(previous_depth - depth) <=
                                                                 kDepthTolerance * std::abs(depth));
}

/// Whether any tap of the lookup shows a surface of this depth. False for NaN.
bool ShowsSurface(const Image1& previous_depth, const HistoryTaps& taps, double depth) {
  for (const HistoryTaps::Tap& tap : taps.tap) {
    if (tap.weight > 0 && SameSurface(depth, previous_depth(tap.x, tap.y))) {
      return true;
    }
  }
  return false;
}

}  // namespace

Status ConsecutiveFrames::Check() const {
  if (test.empty()) {
    return Status::InvalidArgument("the test picture is empty");
  }
  const Size size = {width(), height()};
  STILLRAY_RETURN_IF_ERROR(CheckPlanes("the test picture", test, size));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes("the previous test picture", previous_test, size));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes("the reference", reference, size));
  STILLRAY_RETURN_IF_ERROR(CheckPlanes("the previous reference", previous_reference, size));
  if (!motion.empty()) {
    STILLRAY_RETURN_IF_ERROR(CheckPlanes("the motion", motion, size));
  }
  if (has_depth()) {
    STILLRAY_RETURN_IF_ERROR(CheckSize("the depth", {depth.width(), depth.height()}, size));
    STILLRAY_RETURN_IF_ERROR(
        CheckSize("the previous depth", {previous_depth.width(), previous_depth.height()}, size));
  }
  return Status::Ok();
}

HistoryTaps FindHistory(const ConsecutiveFrames& frames, int x, int y) {
  const double motion_x = frames.motion.empty() ? 0.0 : frames.motion[0](x, y);
  const double motion_y = frames.motion.empty() ? 0.0 : frames.motion[1](x, y);
  HistoryTaps taps = FindTaps(x + motion_x, y + motion_y, {frames.width(), frames.height()});
  taps.visible = taps.visible && (!frames.has_depth() ||
                                  ShowsSurface(frames.previous_depth, taps, frames.depth(x, y)));
  return taps;
}

}  // namespace stillray::quality
