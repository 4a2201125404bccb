// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/parallel.h"
#include "quality/history.h"
#include "quality/picture_pair.h"
#include "stillray/quality.h"

namespace stillray {
namespace {

using quality::ConsecutiveFrames;
using quality::HistoryTaps;

/// Side of a block in pixels; averages over half a block have a sixth of a pixel's noise.
constexpr int kBlock = 8;
/// Minimum of LightChange::square. Below, the residual noise of references with some hundred
/// samples per pixel is as large as the change.
constexpr double kLeastSquare = 1e-6;

bool IsFinite(const Image3& image, int x, int y) {
  return std::isfinite(image[0](x, y)) && std::isfinite(image[1](x, y)) &&
         std::isfinite(image[2](x, y));
}

/// Change of one sequence's luminance at (x, y); NaN if a value is not finite.
double ChangeAt(const Image3& image, const Image3& previous, int x, int y, const HistoryTaps& taps,
                bool display) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  double before = 0;
  for (const HistoryTaps::Tap& tap : taps.tap) {
    if (tap.weight > 0) {
      before += IsFinite(previous, tap.x, tap.y)
                    ? tap.weight * quality::CompressedLuminance(previous, tap.x, tap.y, display)
                    : kNone;
    }
  }
  return IsFinite(image, x, y) ? quality::CompressedLuminance(image, x, y, display) - before
                               : kNone;
}

/// Changes over the pixels of half a block.
struct HalfBlock {
  double test = 0;
  double reference = 0;
  int pixels = 0;

  void Add(const ConsecutiveFrames& in, int x, int y) {
    const HistoryTaps taps = FindHistory(in, x, y);
    if (!taps.visible) {
      return;
    }
    const double test_change = ChangeAt(in.test, in.previous_test, x, y, taps, in.display);
    const double reference_change =
        ChangeAt(in.reference, in.previous_reference, x, y, taps, in.display);
    if (std::isfinite(test_change) && std::isfinite(reference_change)) {
      test += test_change;
      reference += reference_change;
      ++pixels;
    }
  }
};

/// Sums over blocks, weighted by their pixels.
struct ChangeSums {
  double product = 0;  ///< of the test's and the reference's mean change
  double square = 0;   ///< of the reference's mean change
  double pixels = 0;

  /// Adds products of different halves only, whose noise is independent.
  void Add(const HalfBlock& left, const HalfBlock& right) {
    if (left.pixels == 0 || right.pixels == 0) {
      return;
    }
    const double n = left.pixels + right.pixels;
    const double scale = n / (static_cast<double>(left.pixels) * right.pixels);
    product += scale * 0.5 * (left.test * right.reference + right.test * left.reference);
    square += scale * (left.reference * right.reference);
    pixels += n;
  }

  void Add(const ChangeSums& other) {
    product += other.product;
    square += other.square;
    pixels += other.pixels;
  }
};

ChangeSums SumBlock(const ConsecutiveFrames& in, int x0, int y0) {
  std::array<HalfBlock, 2> halves;
  for (int y = y0; y < std::min(y0 + kBlock, in.height()); ++y) {
    for (int x = x0; x < std::min(x0 + kBlock, in.width()); ++x) {
      halves[x < x0 + kBlock / 2 ? 0 : 1].Add(in, x, y);
    }
  }
  ChangeSums sums;
  sums.Add(halves[0], halves[1]);
  return sums;
}

}  // namespace

double LightChange::Share() const {
  return square >= kLeastSquare ? product / square : std::numeric_limits<double>::quiet_NaN();
}

Result<LightChange> MeasureLightChange(const Image3& test, const Image3& previous_test,
                                       const Image3& reference, const Image3& previous_reference,
                                       const Image2& motion, const Image1& depth,
                                       const Image1& previous_depth, bool display) {
  const ConsecutiveFrames frames{test,   previous_test, reference,      previous_reference,
                                 motion, depth,         previous_depth, display};
  STILLRAY_RETURN_IF_ERROR(frames.Check());
  std::vector<ChangeSums> rows(static_cast<size_t>((test.height() + kBlock - 1) / kBlock));
  ParallelRows(test.height(), kBlock, [&](int y0, int) {
    for (int x0 = 0; x0 < test.width(); x0 += kBlock) {
      rows[static_cast<size_t>(y0 / kBlock)].Add(SumBlock(frames, x0, y0));
    }
  });
  ChangeSums total;
  for (const ChangeSums& row : rows) {
    total.Add(row);
  }
  if (total.pixels == 0) {
    return LightChange();
  }
  return LightChange{total.product / total.pixels, total.square / total.pixels};
}

}  // namespace stillray
