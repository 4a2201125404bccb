// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/spline_coefficients.h"

#include <cmath>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "denoise/stages/antialias_shared.h"
#include "stage_test.h"

namespace stillray::spline_coefficients_test {
namespace {

using test::MakePlane;
using test::RandomPlane;

Image3 Grey(const Image1& plane) {
  return test::MakeImage(plane.width(), plane.height(),
                         [&](int x, int y, int) { return plane(x, y); });
}

Image3 Coefficients(const Image3& picture) {
  Image3 out(picture.width(), picture.height());
  cpu::SplineCoefficients(picture, &out);
  return out;
}

/// The sum of the taps around x of a row, far from the edges.
double SumOfTaps(const Image1& row, int x, const vec4& w) {
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    sum += static_cast<double>(w[i]) * row(x + i - 1, 0);
  }
  return sum;
}

/// Solves (c[i-1] + 4 c[i] + c[i+1]) / 6 = f[i] for a periodic row by Gauss-Seidel iteration.
std::vector<double> ExactCoefficients(const std::vector<double>& f) {
  const size_t n = f.size();
  std::vector<double> c = f;
  for (int round = 0; round < 200; ++round) {
    for (size_t i = 0; i < n; ++i) {
      c[i] = (6 * f[i] - c[(i + n - 1) % n] - c[(i + 1) % n]) / 4;
    }
  }
  return c;
}

TEST(SplineCoefficients, AreThoseOfTheSplineThroughThePixels) {
  constexpr int kSize = 64;
  const Image1 row = MakePlane(kSize, 1, [](int x, int) { return 1 + ((x * 37) % 11) / 11.0f; });
  std::vector<double> f(kSize);
  for (int x = 0; x < kSize; ++x) {
    f[static_cast<size_t>(x)] = row(x, 0);
  }
  const std::vector<double> exact = ExactCoefficients(f);
  const Image3 found = Coefficients(Grey(row));
  for (int x = 16; x < kSize - 16; ++x) {  // far from the edges, which differ
    EXPECT_NEAR(found[1](x, 0), exact[static_cast<size_t>(x)], 4e-3) << x;
  }
}

TEST(SplineCoefficients, ASinglePixelIsMet) {
  const Image1 dot =
      MakePlane(21, 21, [](int x, int y) { return x == 10 && y == 10 ? 1.0f : 0.0f; });
  const Image3 c = Coefficients(Grey(dot));
  const vec4 w = CubicSpline(0);
  for (int y = 2; y < 18; ++y) {
    for (int x = 2; x < 18; ++x) {
      double sum = 0;
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
          sum += static_cast<double>(w[i]) * w[j] * c[0](x + i - 1, y + j - 1);
        }
      }
      EXPECT_NEAR(sum, dot(x, y), 2e-3) << x << " " << y;
    }
  }
}

TEST(SplineCoefficients, WeightsAreTheBSpline) {
  for (const float t : {0.0f, 0.25f, 0.5f, 0.9f}) {
    const vec4 w = CubicSpline(t);
    for (int i = 0; i < 4; ++i) {
      const double distance = std::abs(i - 1 - static_cast<double>(t));
      const double near = 2.0 / 3 - distance * distance * (1 - distance / 2);
      const double far = std::pow(2 - distance, 3) / 6;
      EXPECT_NEAR(w[i], distance < 1 ? near : far, 1e-6) << t << " " << i;
    }
  }
}

TEST(SplineCoefficients, AConstantStaysConstant) {
  const Image3 c = Coefficients(Grey(MakePlane(19, 13, [](int, int) { return 3.0f; })));
  for (int y = 0; y < 13; ++y) {
    for (int x = 0; x < 19; ++x) {
      EXPECT_NEAR(c[2](x, y), 3, 2e-6) << x << " " << y;
    }
  }
}

TEST(SplineCoefficients, FineTextureOutlivesTenShifts) {
  constexpr int kSize = 200;
  constexpr double kFrequency = 0.3;  // cycles per pixel
  const auto wave = [](double x) { return std::sin(2 * M_PI * kFrequency * x); };
  Image1 spline = MakePlane(kSize, 1, [&](int x, int) { return static_cast<float>(wave(x)); });
  Image1 kernel = spline;
  for (int step = 0; step < 10; ++step) {
    const Image3 c = Coefficients(Grey(spline));
    const Image1 old = kernel;
    for (int x = 1; x + 2 < kSize; ++x) {
      spline(x, 0) = static_cast<float>(SumOfTaps(c[0], x, CubicSpline(0.5f)));
      kernel(x, 0) = static_cast<float>(SumOfTaps(old, x, CatmullRom(0.5f)));
    }
  }
  const auto amplitude = [&](const Image1& row) {
    double product = 0;
    double square = 0;
    for (int x = 80; x < 120; ++x) {
      product += row(x, 0) * wave(x + 5);
      square += wave(x + 5) * wave(x + 5);
    }
    return product / square;
  };
  // The frequency response of one half-pixel step: (1.125 cos(a) - 0.125 cos(3 a)) with a = pi f,
  // and for the spline its ratio to the response at the pixels.
  const double a = M_PI * kFrequency;
  const double of_kernel = 1.125 * std::cos(a) - 0.125 * std::cos(3 * a);
  const double of_spline = (23 * std::cos(a) + std::cos(3 * a)) / 24 / ((2 + std::cos(2 * a)) / 3);
  EXPECT_NEAR(amplitude(kernel), std::pow(of_kernel, 10), 0.01);
  EXPECT_NEAR(amplitude(spline), std::pow(of_spline, 10), 0.02);
  EXPECT_GT(amplitude(spline), 2 * amplitude(kernel));
}

TEST(SplineCoefficients, VersionsAgree) {
  test::ForSizesAndTargets([](int width, int height) {
    const Image3 picture = Grey(RandomPlane(width, height, 1, 4));
    Image3 expected(width, height);
    Image3 got(width, height);
    reference::SplineCoefficients(picture, &expected);
    cpu::SplineCoefficients(picture, &got);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        ASSERT_NEAR(got[0](x, y), expected[0](x, y), 2e-5) << x << " " << y;
      }
    }
  });
}

}  // namespace
}  // namespace stillray::spline_coefficients_test
