// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include "quality/history.h"
#include "quality/picture_pair.h"
#include "quality/row_sums.h"
#include "stillray/quality.h"

namespace stillray {
namespace {

using quality::ConsecutiveFrames;
using quality::HistoryTaps;

/// A sum of absolute differences and their number.
struct ErrorSum {
  double sum = 0;
  int64_t values = 0;
};

/// Bilinear lookup of the plane's compressed values; NaN if a tap is not finite.
double Lookup(const Image1& plane, const HistoryTaps& taps, bool display) {
  double sum = 0;
  for (const HistoryTaps::Tap& tap : taps.tap) {
    if (tap.weight > 0) {
      const float value = plane(tap.x, tap.y);
      sum += std::isfinite(value) ? tap.weight * quality::CompressValue(value, display)
                                  : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return sum;
}

/// Adds one pixel's errors, unless one of its values or of its history is not finite.
void AddPixel(const ConsecutiveFrames& in, int x, int y, const HistoryTaps& taps, ErrorSum* total) {
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

ErrorSum SumOfRow(const ConsecutiveFrames& in, int y) {
  ErrorSum total;
  for (int x = 0; x < in.test.width(); ++x) {
    const HistoryTaps taps = FindHistory(in, x, y);
    if (taps.visible) {
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
  const ConsecutiveFrames frames{test,   previous_test, reference,      previous_reference,
                                 motion, depth,         previous_depth, display};
  STILLRAY_RETURN_IF_ERROR(frames.Check());
  std::vector<int64_t> values(static_cast<size_t>(test.height()));
  const double sum = quality::SumRows(test.height(), [&](int y) {
    const ErrorSum row = SumOfRow(frames, y);
    values[static_cast<size_t>(y)] = row.values;
    return row.sum;
  });
  const int64_t count = std::accumulate(values.begin(), values.end(), int64_t{0});
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace stillray
