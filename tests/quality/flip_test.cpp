// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "flip_reference.h"
#include "pictures.h"
#include "quality/flip_colour.h"
#include "quality/metrics.h"
#include "stillray/quality.h"

namespace stillray::flip_test {
namespace {

using testing::ElementsAre;

// Float against double. Where features are compared, the square root of a small difference
// magnifies rounding: an error of 1e-7 becomes 3e-4.
constexpr double kPixelTolerance = 1e-3;
constexpr double kMeanTolerance = 1e-4;

double Flip(const Image3& test, const Image3& reference) {
  const Result<ImageMetrics> metrics = CompareImages(test, reference, true);
  EXPECT_TRUE(metrics.ok()) << metrics.status().message();
  return metrics.ok() ? metrics->flip : -1;
}

void ExpectMapNear(const Image1& map, const std::vector<double>& expected) {
  double sum = 0;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      const double value = expected[static_cast<size_t>(y * map.width() + x)];
      ASSERT_NEAR(map(x, y), value, kPixelTolerance) << "pixel " << x << ", " << y;
      sum += map(x, y);
    }
  }
  EXPECT_NEAR(sum / static_cast<double>(expected.size()), flip_reference::Mean(expected),
              kMeanTolerance);
}

TEST(FlipColour, WhiteIsOneAndClippingKeepsDisplayColours) {
  const quality::RelativeXyz white = quality::XyzOfRgb(1, 1, 1);
  EXPECT_NEAR(white.x, 1, 1e-6);
  EXPECT_NEAR(white.y, 1, 1e-6);
  EXPECT_NEAR(white.z, 1, 1e-6);
  const quality::RelativeXyz colour = quality::XyzOfRgb(0.2f, 0.9f, 0.4f);
  const quality::RelativeXyz kept = quality::ClipToDisplay(colour);
  EXPECT_NEAR(kept.x, colour.x, 1e-6);
  EXPECT_NEAR(kept.y, colour.y, 1e-6);
  EXPECT_NEAR(kept.z, colour.z, 1e-6);
}

TEST(FlipColour, CubeRootIsExactToFourUnitsInTheLastPlace) {
  for (float t = 0.005f; t < 1.5f; t *= 1.0003f) {
    const float exact = static_cast<float>(std::cbrt(static_cast<double>(t)));
    const float unit = std::nextafter(exact, 2.0f) - exact;
    ASSERT_NEAR(quality::CubeRoot(t), exact, 4 * unit) << t;
  }
}

// CIELAB of the sRGB primaries as colour tables print it; a and b times L / 100.
TEST(FlipColour, PrimariesHaveTheirKnownLab) {
  const quality::HuntLab red = quality::HuntLabOfXyz(quality::XyzOfRgb(1, 0, 0));
  EXPECT_NEAR(red.l, 53.24, 0.01);
  EXPECT_NEAR(red.a, 80.09 * 0.5324, 0.02);
  EXPECT_NEAR(red.b, 67.20 * 0.5324, 0.02);
  const quality::HuntLab blue = quality::HuntLabOfXyz(quality::XyzOfRgb(0, 0, 1));
  EXPECT_NEAR(blue.l, 32.30, 0.01);
  EXPECT_NEAR(blue.a, 79.19 * 0.3230, 0.02);
  EXPECT_NEAR(blue.b, -107.86 * 0.3230, 0.02);
}

TEST(Flip, EqualPicturesHaveNoError) {
  const Image3 noise = NoisePicture(37, 23, 1);
  EXPECT_EQ(Flip(noise, noise), 0);
  const Result<ImageMetrics> radiance = CompareImages(noise, noise, false);
  ASSERT_TRUE(radiance.ok());
  EXPECT_EQ(radiance->flip, 0);
  EXPECT_EQ(radiance->hdr_flip, 0);
}

// Without features FLIP is the colour error alone: HyAB of black and white is 100, to the power of
// 0.7 it is 25.1189; the greatest difference, green to blue, is 203.4 to the power of 0.7, 41.29;
// above the knee at 0.4 of it, the error is 0.95 + 0.05 (25.1189 - 16.52) / (41.29 - 16.52).
TEST(Flip, BlackAndWhite) {
  const Image3 black = ConstantPicture(32, 32, {0, 0, 0});
  const Image3 white = ConstantPicture(32, 32, {1, 1, 1});
  EXPECT_NEAR(Flip(white, black), 0.9674, 2e-4);
  EXPECT_NEAR(Flip(black, white), 0.9674, 2e-4);
}

TEST(Flip, GreenAndBlueAreTheGreatestDifference) {
  const Image3 green = ConstantPicture(24, 24, {0, 1, 0});
  const Image3 blue = ConstantPicture(24, 24, {0, 0, 1});
  EXPECT_NEAR(Flip(green, blue), 1, 1e-5);
}

TEST(Flip, LdrIsSymmetric) {
  const Image3 a = ScenePicture(40, 30);
  const Image3 b = NoisePicture(40, 30, 3);
  EXPECT_EQ(Flip(a, b), Flip(b, a));
}

TEST(Flip, GrowsWithNoise) {
  const Image3 scene = ScenePicture(48, 32, 0.5f);
  const Image3 noise = NoisePicture(48, 32, 5);
  double last = 0;
  for (const float amount : {0.01f, 0.03f, 0.1f, 0.3f}) {
    const double error = Flip(Blend(scene, noise, amount), scene);
    EXPECT_GT(error, last) << amount;
    last = error;
  }
  EXPECT_LT(last, 1);
}

// An edge that is missing counts more than the colours it divides: the same two colours, as halves
// against a plain mean, err more near the edge than far from it.
TEST(Flip, MissingEdgeCountsMoreThanItsColours) {
  Image3 halves = ConstantPicture(96, 24, {0.3f, 0.3f, 0.3f});
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 24; ++y) {
      for (int x = 48; x < 96; ++x) {
        halves[c](x, y) = 0.32f;
      }
    }
  }
  const Image3 plain = ConstantPicture(96, 24, {0.3f, 0.3f, 0.3f});
  const Result<Image1> map = MakeErrorMap(plain, halves, true, ErrorMap::kFlip);
  ASSERT_TRUE(map.ok());
  EXPECT_EQ((*map)(0, 12), 0);
  EXPECT_GT((*map)(50, 12), 1.05f * (*map)(95, 12));
}

TEST(Flip, MatchesTheEquationsOnAScene) {
  const Image3 reference = ScenePicture(45, 33, 0.8f);
  const Image3 test = Blend(reference, NoisePicture(45, 33, 7), 0.15f);
  const Result<Image1> map = MakeErrorMap(test, reference, true, ErrorMap::kFlip);
  ASSERT_TRUE(map.ok());
  ExpectMapNear(*map, flip_reference::LdrFlip(test, reference));
}

// Tiles are 256 pixels wide and 64 high: nothing may show at their borders.
TEST(Flip, MatchesTheEquationsAcrossTiles) {
  const Image3 wide_reference = ScenePicture(263, 5, 0.8f);
  const Image3 wide = Blend(wide_reference, NoisePicture(263, 5, 8), 0.15f);
  Result<Image1> map = MakeErrorMap(wide, wide_reference, true, ErrorMap::kFlip);
  ASSERT_TRUE(map.ok());
  ExpectMapNear(*map, flip_reference::LdrFlip(wide, wide_reference));
  const Image3 high_reference = ScenePicture(3, 131, 0.8f);
  const Image3 high = Blend(high_reference, NoisePicture(3, 131, 9), 0.15f);
  map = MakeErrorMap(high, high_reference, true, ErrorMap::kFlip);
  ASSERT_TRUE(map.ok());
  ExpectMapNear(*map, flip_reference::LdrFlip(high, high_reference));
}

TEST(Flip, TinyPictures) {
  const Image3 reference = ConstantPicture(1, 1, {0.5f, 0.2f, 0.7f});
  const Image3 test = ConstantPicture(1, 1, {0.4f, 0.3f, 0.1f});
  EXPECT_NEAR(Flip(test, reference), flip_reference::Mean(flip_reference::LdrFlip(test, reference)),
              kMeanTolerance);
}

TEST(HdrFlip, ExposuresMatchTheEquations) {
  const Image3 reference = NoisePicture(31, 20, 11, 40.0f);
  const Result<quality::PicturePair> pair = quality::MakePicturePair(reference, reference, false);
  ASSERT_TRUE(pair.ok());
  const std::vector<double> expected = flip_reference::Exposures(reference);
  const std::vector<quality::Exposure> exposures = quality::HdrFlipExposures(*pair);
  ASSERT_EQ(exposures.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_TRUE(exposures[i].tonemap);
    EXPECT_NEAR(exposures[i].stops, expected[i], 1e-5);
  }
}

// The curve reaches 0.85 at 1.5187: found by bisection of x 0.6 (2.51 x 0.6 + 0.03) / ...
TEST(HdrFlip, ExposuresOfAConstantPicture) {
  const Image3 grey = ConstantPicture(8, 8, {4, 4, 4});
  const Result<quality::PicturePair> pair = quality::MakePicturePair(grey, grey, false);
  ASSERT_TRUE(pair.ok());
  const std::vector<quality::Exposure> exposures = quality::HdrFlipExposures(*pair);
  ASSERT_EQ(exposures.size(), 2u);
  EXPECT_EQ(exposures[0].stops, exposures[1].stops);
  const double shown = 4 * std::exp2(exposures[0].stops) * 0.6;
  EXPECT_NEAR((2.51 * shown + 0.03) * shown / ((2.43 * shown + 0.59) * shown + 0.14), 0.85, 1e-5);
}

// Three of four pixels are black: the exposures must show the one that is not.
TEST(HdrFlip, MostlyBlackReferenceUsesThePixelsThatAreNot) {
  Image3 dark = ConstantPicture(4, 1, {0, 0, 0});
  for (int c = 0; c < 3; ++c) {
    dark[c](2, 0) = 4;
  }
  const Image3 grey = ConstantPicture(8, 8, {4, 4, 4});
  const Result<quality::PicturePair> dark_pair = quality::MakePicturePair(dark, dark, false);
  const Result<quality::PicturePair> grey_pair = quality::MakePicturePair(grey, grey, false);
  ASSERT_TRUE(dark_pair.ok() && grey_pair.ok());
  const auto exposures = quality::HdrFlipExposures(*dark_pair);
  ASSERT_EQ(exposures.size(), 2u);
  EXPECT_NEAR(exposures[0].stops, quality::HdrFlipExposures(*grey_pair)[0].stops, 1e-6);
}

TEST(HdrFlip, BlackReferenceIsSeenAtExposureZero) {
  const Image3 black = ConstantPicture(8, 8, {0, 0, 0});
  const Image3 bright = ConstantPicture(8, 8, {1, 1, 1});
  const Result<ImageMetrics> metrics = CompareImages(bright, black, false);
  ASSERT_TRUE(metrics.ok());
  EXPECT_NEAR(metrics->hdr_flip,
              flip_reference::Mean(flip_reference::LdrFlip(flip_reference::Develop(bright, 0),
                                                           flip_reference::Develop(black, 0))),
              kMeanTolerance);
}

TEST(HdrFlip, MatchesTheEquations) {
  const Image3 reference = ScenePicture(36, 27, 20.0f);
  const Image3 test = Blend(reference, NoisePicture(36, 27, 13), 4.0f);
  const Result<Image1> map = MakeErrorMap(test, reference, false, ErrorMap::kHdrFlip);
  ASSERT_TRUE(map.ok());
  ExpectMapNear(*map, flip_reference::HdrFlip(test, reference));
}

TEST(HdrFlip, LdrFlipOfRadianceIsTakenInTheMiddleOfTheRange) {
  const Image3 reference = ScenePicture(36, 27, 20.0f);
  const Image3 test = Blend(reference, NoisePicture(36, 27, 13), 4.0f);
  const std::vector<double> stops = flip_reference::Exposures(reference);
  const double middle = 0.5 * (stops.front() + stops.back());
  const Result<Image1> map = MakeErrorMap(test, reference, false, ErrorMap::kFlip);
  ASSERT_TRUE(map.ok());
  ExpectMapNear(*map, flip_reference::LdrFlip(flip_reference::Develop(test, middle),
                                              flip_reference::Develop(reference, middle)));
}

// Scaling both pictures moves the exposures and nothing else.
TEST(HdrFlip, DoesNotDependOnTheUnitOfRadiance) {
  const Image3 reference = ScenePicture(40, 30, 0.5f);
  const Image3 test = Blend(reference, NoisePicture(40, 30, 17), 0.2f);
  const Image3 none(40, 30);
  const Result<ImageMetrics> once = CompareImages(test, reference, false);
  const Result<ImageMetrics> scaled =
      CompareImages(Blend(none, test, 1024.0f), Blend(none, reference, 1024.0f), false);
  ASSERT_TRUE(once.ok() && scaled.ok());
  EXPECT_NEAR(scaled->hdr_flip, once->hdr_flip, 1e-5);
  EXPECT_NEAR(scaled->flip, once->flip, 1e-5);
}

// Values at the ends of float's range must neither overflow nor make the range endless.
TEST(HdrFlip, SurvivesExtremeRadiance) {
  Image3 reference = ScenePicture(16, 16);
  reference[0](3, 3) = 3e38f;
  reference[1](4, 4) = 1e-45f;
  Image3 test = reference;
  test[2](8, 8) = 3e38f;
  const Result<ImageMetrics> metrics = CompareImages(test, reference, false);
  ASSERT_TRUE(metrics.ok());
  EXPECT_GT(metrics->hdr_flip, 0);
  EXPECT_LE(metrics->hdr_flip, 1);
}

}  // namespace
}  // namespace stillray::flip_test
