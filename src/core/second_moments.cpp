// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/second_moments.h"

#include <algorithm>
#include <cmath>

#include "core/colour.h"
#include "core/guides.h"
#include "core/pixels.h"

namespace stillray {
namespace {

/// Of the window of results.
constexpr int kRadius = 2;
constexpr int kCoefficient[3] = {1, -2, 1};

bool HasSeveral(const Image1& samples) {
  for (int y = 0; y < samples.height(); ++y) {
    const float* row = samples.Row(y);
    if (std::any_of(row, row + samples.width(), [](float n) { return n > 1; })) {
      return true;
    }
  }
  return false;
}

/// The luminance of light divided by its albedo; NaN where there is no sample or no surface.
Image1 Luminance(const Frame& frame, const Signal& signal) {
  const Image3& light = signal.radiance;
  const Image3& albedo = AlbedoOf(frame.guides, signal.kind);
  Image1 luminance(frame.width, frame.height);
  ForEachPixel(frame.width, frame.height, [&](int x, int y) {
    const bool seen = frame.samples(x, y) > 0 && std::isfinite(frame.guides.depth(x, y));
    float sum[3];
    for (int c = 0; c < 3; ++c) {
      sum[c] = Demodulate(light[c](x, y), albedo.empty() ? 1.0f : albedo[c](x, y));
    }
    const float l = Luminance709(sum[0], sum[1], sum[2]);
    luminance(x, y) = seen && std::isfinite(l) ? l : NAN;
  });
  return luminance;
}

/// Squares of filtered light, and the variances that samples of variance 1 would give them; both 0
/// where a pixel is missing.
struct Residuals {
  Image1 square;
  Image1 variance;
};

/// \param variances  of the light of each pixel, if a sample has the variance 1
Residuals FilterLight(const Image1& luminance, const Image1& variances) {
  const int width = luminance.width();
  const int height = luminance.height();
  Residuals residuals = {Image1(width, height), Image1(width, height)};
  ForEachPixel(width, height, [&](int x, int y) {
    if (x == 0 || y == 0 || x == width - 1 || y == height - 1) {
      return;
    }
    float sum = 0;
    float variance = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto c = static_cast<float>(kCoefficient[dx + 1] * kCoefficient[dy + 1]);
        sum += c * luminance(x + dx, y + dy);
        variance += c * c * variances(x + dx, y + dy);
      }
    }
    if (std::isfinite(sum * sum) && std::isfinite(variance)) {
      residuals.square(x, y) = sum * sum;
      residuals.variance(x, y) = variance;
    }
  });
  return residuals;
}

/// Sums over 2 kRadius + 1 pixels in each direction.
Image1 WindowSums(const Image1& plane) {
  const int width = plane.width();
  const int height = plane.height();
  Image1 rows(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    for (int i = std::max(x - kRadius, 0); i <= std::min(x + kRadius, width - 1); ++i) {
      rows(x, y) += plane(i, y);
    }
  });
  Image1 sums(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    for (int i = std::max(y - kRadius, 0); i <= std::min(y + kRadius, height - 1); ++i) {
      sums(x, y) += rows(x, i);
    }
  });
  return sums;
}

}  // namespace

void EstimateSecondMoments(Frame* frame) {
  if (frame->samples.empty() || !HasSeveral(frame->samples)) {
    return;
  }
  Image1 inverse(frame->width, frame->height);
  ForEachPixel(frame->width, frame->height,
               [&](int x, int y) { inverse(x, y) = 1.0f / frame->samples(x, y); });
  for (Signal& signal : frame->signals) {
    if (!signal.second_moment.empty()) {
      continue;
    }
    const Image1 luminance = Luminance(*frame, signal);
    const Residuals residuals = FilterLight(luminance, inverse);
    const Image1 squares = WindowSums(residuals.square);
    const Image1 variances = WindowSums(residuals.variance);
    signal.second_moment = Image1(frame->width, frame->height);
    ForEachPixel(frame->width, frame->height, [&](int x, int y) {
      const float l = luminance(x, y);
      const float n = frame->samples(x, y);
      if (std::isnan(l)) {
        return;
      }
      const float v = variances(x, y) > 0 ? squares(x, y) / variances(x, y) : 0.0f;
      signal.second_moment(x, y) = l * l + v * std::max(n - 1, 0.0f) / n;
    });
  }
}

}  // namespace stillray
