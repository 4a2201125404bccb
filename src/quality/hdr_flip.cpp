// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The exposures of HDR-FLIP: Andersson, Nilsson, Shirley and Akenine-Moeller, "Visualizing Errors
// in Rendered High Dynamic Range Images" (2021), section 3. Departs from it where half of the
// reference or more is black, for which the paper's median gives no exposure: then the median of
// the pixels that are not black is used. An all-black reference has exposure 0.
#include <algorithm>
#include <cmath>

#include "quality/flip_colour.h"
#include "quality/flip_tonemap.h"
#include "quality/metrics.h"

namespace stillray::quality {
namespace {

/// The tone mapped luminance of the reference's brightest and median pixel at the ends of the
/// range.
constexpr double kTarget = 0.85;

/// The luminance that the curve maps to kTarget: the larger root of a quadratic equation.
double LuminanceAtTarget() {
  using A = FlipAces;
  const double a = A::kSquare - kTarget * A::kBelowSquare;
  const double b = A::kLinear - kTarget * A::kBelowLinear;
  const double c = -kTarget * A::kBelowConstant;
  return (-b + std::sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
}

/// Luminances of the valid pixels that are not black, unordered.
std::vector<double> PositiveLuminances(const PicturePair& pair, int64_t* black) {
  std::vector<double> luminances;
  luminances.reserve(static_cast<size_t>(pair.valid_count));
  for (int y = 0; y < pair.height(); ++y) {
    for (int x = 0; x < pair.width(); ++x) {
      if (pair.valid(x, y) == 0) {
        continue;
      }
      double luminance = 0;
      for (int c = 0; c < 3; ++c) {
        luminance += kXyzOfRgb[1][static_cast<size_t>(c)] * std::max(pair.reference[c](x, y), 0.0f);
      }
      if (luminance > 0) {
        luminances.push_back(luminance);
      } else {
        ++*black;
      }
    }
  }
  return luminances;
}

/// The median. `values` is not empty and gets reordered.
double Median(std::vector<double>* values, int64_t zeros) {
  const size_t all = values->size() + static_cast<size_t>(zeros);
  // Positions of the median among zeros and values together, relative to the values.
  size_t upper = all / 2;
  size_t lower = (all - 1) / 2;
  if (lower < static_cast<size_t>(zeros)) {
    upper = values->size() / 2;
    lower = (values->size() - 1) / 2;
  } else {
    upper -= static_cast<size_t>(zeros);
    lower -= static_cast<size_t>(zeros);
  }
  std::nth_element(values->begin(), values->begin() + static_cast<ptrdiff_t>(upper), values->end());
  const double above = (*values)[upper];
  const double below =
      lower == upper
          ? above
          : *std::max_element(values->begin(), values->begin() + static_cast<ptrdiff_t>(upper));
  return 0.5 * (below + above);
}

struct ExposureRange {
  double first = 0;
  double last = 0;
};

ExposureRange FindRange(const PicturePair& pair) {
  int64_t black = 0;
  std::vector<double> luminances = PositiveLuminances(pair, &black);
  if (luminances.empty()) {
    return {};
  }
  const double brightest = *std::max_element(luminances.begin(), luminances.end());
  const double target = std::log2(LuminanceAtTarget());
  return {target - std::log2(brightest), target - std::log2(Median(&luminances, black))};
}

}  // namespace

std::vector<Exposure> HdrFlipExposures(const PicturePair& pair) {
  const ExposureRange range = FindRange(pair);
  const double length = range.last - range.first;
  const int count = std::max(2, static_cast<int>(std::ceil(length)));
  std::vector<Exposure> exposures;
  for (int i = 0; i < count; ++i) {
    exposures.push_back({true, range.first + length * i / (count - 1)});
  }
  return exposures;
}

Exposure LdrFlipExposure(const PicturePair& pair) {
  if (pair.display) {
    return {};
  }
  const ExposureRange range = FindRange(pair);
  return {true, 0.5 * (range.first + range.last)};
}

}  // namespace stillray::quality
