// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::specks_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Numbers of pixels.
struct Specks {
  double bright = 0;
  double dark = 0;
};

Specks Measure(const Image3& test, const Image3& reference, bool display = false) {
  const Result<ImageMetrics> metrics = CompareImages(test, reference, display);
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  if (!metrics.ok()) {
    return {-1, -1};
  }
  const double pixels =
      static_cast<double>(test.width()) * test.height() - static_cast<double>(metrics->non_finite);
  return {metrics->bright_specks * 1e-4 * pixels, metrics->dark_specks * 1e-4 * pixels};
}

void ExpectSpecks(const Specks& specks, double bright, double dark) {
  EXPECT_NEAR(specks.bright, bright, 1e-9);
  EXPECT_NEAR(specks.dark, dark, 1e-9);
}

void SetPixel(int x, int y, float value, Image3* image) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value;
  }
}

TEST(Specks, EqualPicturesHaveNone) {
  const Image3 noise = NoisePicture(23, 17, 1, 4.0f);
  ExpectSpecks(Measure(noise, noise), 0, 0);
  ExpectSpecks(Measure(noise, noise, true), 0, 0);
}

TEST(Specks, AreGivenInTenThousandthsOfThePixels) {
  const Image3 reference = ConstantPicture(20, 10, {1, 1, 1});
  Image3 test = reference;
  SetPixel(7, 5, 5, &test);
  EXPECT_DOUBLE_EQ(CompareImages(test, reference, false)->bright_specks, 1e4 / 200);
}

// In the middle, on the border and in a corner, where windows have nine, six and four pixels.
TEST(Specks, OnePixelIsOneSpeck) {
  const Image3 reference = ConstantPicture(20, 10, {1, 1, 1});
  for (const auto& [x, y] : {std::pair{7, 5}, {0, 4}, {19, 4}, {6, 0}, {6, 9}, {0, 0}, {19, 9}}) {
    Image3 test = reference;
    SetPixel(x, y, 5, &test);
    ExpectSpecks(Measure(test, reference), 1, 0);
    SetPixel(x, y, 0.2f, &test);
    ExpectSpecks(Measure(test, reference), 0, 1);
  }
}

// 1 lies at 0.5 on the curve, 27/23 at 0.54.
TEST(Specks, BeginAtADistanceOfFourHundredths) {
  const Image3 reference = ConstantPicture(9, 9, {1, 1, 1});
  Image3 test = reference;
  SetPixel(4, 4, 0.541f / 0.459f, &test);
  ExpectSpecks(Measure(test, reference), 1, 0);
  SetPixel(4, 4, 0.539f / 0.461f, &test);
  ExpectSpecks(Measure(test, reference), 0, 0);
  SetPixel(4, 4, 0.459f / 0.541f, &test);
  ExpectSpecks(Measure(test, reference), 0, 1);
  SetPixel(4, 4, 0.461f / 0.539f, &test);
  ExpectSpecks(Measure(test, reference), 0, 0);
}

// Of display pictures the sRGB byte counts: 11 of 255 are more than 0.04, 10 are less.
TEST(Specks, DisplayPicturesCountAsTheirFilesValues) {
  const auto linear = [](double byte) {
    return static_cast<float>(std::pow((byte / 255 + 0.055) / 1.055, 2.4));
  };
  const Image3 reference = ConstantPicture(9, 9, {linear(100), linear(100), linear(100)});
  Image3 test = reference;
  SetPixel(4, 4, linear(111), &test);
  ExpectSpecks(Measure(test, reference, true), 1, 0);
  SetPixel(4, 4, linear(110), &test);
  ExpectSpecks(Measure(test, reference, true), 0, 0);
}

TEST(Specks, WhatStandsOutInTheReferenceTooIsNone) {
  Image3 reference = ConstantPicture(9, 9, {1, 1, 1});
  SetPixel(4, 4, 5, &reference);
  ExpectSpecks(Measure(reference, reference), 0, 0);
  // Fainter than the reference's: no speck either.
  Image3 test = ConstantPicture(9, 9, {1, 1, 1});
  SetPixel(4, 4, 2, &test);
  ExpectSpecks(Measure(test, reference), 0, 0);
  // But one in the other direction is.
  SetPixel(4, 4, 0.2f, &test);
  ExpectSpecks(Measure(test, reference), 0, 1);
}

TEST(Specks, EdgesAndPatchesAreNone) {
  const Image3 reference = ConstantPicture(16, 9, {1, 1, 1});
  Image3 test = reference;
  for (int y = 0; y < 9; ++y) {
    for (int x = 8; x < 16; ++x) {
      SetPixel(x, y, 5, &test);
    }
  }
  ExpectSpecks(Measure(test, reference), 0, 0);
}

TEST(Specks, PixelsThatAreNotFiniteAreLeftOut) {
  const Image3 reference = ConstantPicture(9, 9, {1, 1, 1});
  Image3 test = reference;
  SetPixel(2, 2, kNan, &test);
  SetPixel(6, 6, 5, &test);
  ExpectSpecks(Measure(test, reference), 1, 0);
  EXPECT_DOUBLE_EQ(CompareImages(test, reference, false)->bright_specks, 1e4 / 80);
  // Both pictures hold black where the reference is invalid.
  Image3 broken = reference;
  SetPixel(2, 2, kNan, &broken);
  ExpectSpecks(Measure(reference, broken), 0, 0);
}

/// value - median of the window, as the definition says.
double Distance(const Image3& image, int x, int y) {
  const auto light = [&image](int u, int v) {
    const double l = 0.2126 * image[0](u, v) + 0.7152 * image[1](u, v) + 0.0722 * image[2](u, v);
    return l > 0 ? l / (1 + l) : 0;
  };
  std::vector<double> window;
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      if (u >= 0 && v >= 0 && u < image.width() && v < image.height()) {
        window.push_back(light(u, v));
      }
    }
  }
  std::sort(window.begin(), window.end());
  const size_t half = window.size() / 2;
  const double median =
      window.size() % 2 == 1 ? window[half] : (window[half - 1] + window[half]) / 2;
  return light(x, y) - median;
}

TEST(Specks, AgreeWithTheDefinitionOnNoise) {
  for (const auto& [width, height] : {std::pair{37, 21}, {1, 1}, {1, 9}, {9, 2}, {2, 2}}) {
    const Image3 reference = NoisePicture(width, height, 1, 2.0f);
    // With some negative values.
    const Image3 test =
        Blend(NoisePicture(width, height, 2, 2.0f), NoisePicture(width, height, 3), -0.4f);
    Specks expected;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double t = Distance(test, x, y);
        const double r = Distance(reference, x, y);
        expected.bright += t > 0 && t - std::max(r, 0.0) > 0.04;
        expected.dark += t < 0 && -t - std::max(-r, 0.0) > 0.04;
      }
    }
    ExpectSpecks(Measure(test, reference), expected.bright, expected.dark);
    if (width > 30) {
      EXPECT_GT(expected.bright, 50);
      EXPECT_GT(expected.dark, 50);
    }
  }
}

}  // namespace
}  // namespace stillray::specks_test
