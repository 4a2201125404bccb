// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::temporal_error_test {
namespace {

using testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

const Image1 kNoDepth;
const Image2 kNoMotion;

Image2 ConstantMotion(int width, int height, float x, float y) {
  Image2 motion(width, height);
  motion[0].Fill(x);
  motion[1].Fill(y);
  return motion;
}

Image1 ConstantDepth(int width, int height, float depth) {
  Image1 image(width, height);
  image.Fill(depth);
  return image;
}

/// `image` moved right by `dx` and down by `dy` pixels; zero where nothing came from.
Image3 Shifted(const Image3& image, int dx, int dy) {
  Image3 shifted(image.width(), image.height());
  for (int c = 0; c < 3; ++c) {
    for (int y = std::max(0, dy); y < std::min(image.height(), image.height() + dy); ++y) {
      for (int x = std::max(0, dx); x < std::min(image.width(), image.width() + dx); ++x) {
        shifted[c](x, y) = image[c](x - dx, y - dy);
      }
    }
  }
  return shifted;
}

double Error(const Result<double>& error) {
  EXPECT_TRUE(error.ok()) << error.status().message();
  return error.ok() ? *error : -1;
}

TEST(TemporalError, SteadyPicturesHaveNone) {
  const Image3 test = NoisePicture(12, 9, 1);
  const Image3 reference = NoisePicture(12, 9, 2);
  EXPECT_EQ(
      Error(TemporalError(test, test, reference, reference, kNoMotion, kNoDepth, kNoDepth, false)),
      0);
}

// The reference stays at 1, the test goes from 1 to 3: compressed, from 1/2 to 3/4.
TEST(TemporalError, CountsChangeThatTheReferenceLacks) {
  const Image3 one = ConstantPicture(6, 4, {1, 1, 1});
  const Image3 three = ConstantPicture(6, 4, {3, 3, 3});
  EXPECT_NEAR(Error(TemporalError(three, one, one, one, kNoMotion, kNoDepth, kNoDepth, false)),
              0.25, 1e-9);
  // And the other way round, when only the reference changes.
  EXPECT_NEAR(Error(TemporalError(one, one, three, one, kNoMotion, kNoDepth, kNoDepth, false)),
              0.25, 1e-9);
}

TEST(TemporalError, ChangeThatTheReferenceSharesIsFree) {
  const Image3 one = ConstantPicture(6, 4, {1, 1, 1});
  const Image3 three = ConstantPicture(6, 4, {3, 3, 3});
  EXPECT_EQ(Error(TemporalError(three, one, three, one, kNoMotion, kNoDepth, kNoDepth, false)), 0);
}

TEST(TemporalError, DisplayPicturesCountAsTheirFilesValues) {
  const Image3 black = ConstantPicture(6, 4, {0, 0, 0});
  const Image3 white = ConstantPicture(6, 4, {1, 1, 1});
  EXPECT_NEAR(Error(TemporalError(white, black, black, black, kNoMotion, kNoDepth, kNoDepth, true)),
              1, 1e-6);
}

// Everything moves 2 right and 1 down: the point at p was at p + (-2, -1).
TEST(TemporalError, FollowsTheMotion) {
  const Image3 before = NoisePicture(16, 11, 3);
  const Image3 after = Shifted(before, 2, 1);
  const Image3 black(16, 11);
  EXPECT_EQ(Error(TemporalError(after, before, black, black, ConstantMotion(16, 11, -2, -1),
                                kNoDepth, kNoDepth, false)),
            0);
  EXPECT_GT(Error(TemporalError(after, before, black, black, ConstantMotion(16, 11, 2, 1), kNoDepth,
                                kNoDepth, false)),
            0.05);
}

// Between two pixels of a ramp the lookup is their mean. The first column's history is half a pixel
// off the picture, which is still within the first pixel's area, and reads that pixel.
TEST(TemporalError, LooksUpBetweenPixels) {
  Image3 ramp(5, 1);
  for (int c = 0; c < 3; ++c) {
    for (int x = 0; x < 5; ++x) {
      const float compressed = 0.1f * static_cast<float>(x);
      ramp[c](x, 0) = compressed / (1 - compressed);
    }
  }
  const Image3 black(5, 1);
  // At p the test changes by 0.1 x - 0.1 (x - 0.5) = 0.05; in the first column by 0.
  EXPECT_NEAR(Error(TemporalError(ramp, ramp, black, black, ConstantMotion(5, 1, -0.5f, 0),
                                  kNoDepth, kNoDepth, false)),
              4 * 0.05 / 5, 1e-7);
}

TEST(TemporalError, HistoryOutsideThePictureIsLeftOut) {
  Image3 test = ConstantPicture(4, 3, {0, 0, 0});
  const Image3 black(4, 3);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 3; ++y) {
      test[c](3, y) = 1;  // the column whose history lies one pixel outside
      test[c](0, y) = 1;  // 1/2 after compression
    }
  }
  EXPECT_NEAR(Error(TemporalError(test, black, black, black, ConstantMotion(4, 3, 1, 0), kNoDepth,
                                  kNoDepth, false)),
              0.5 / 3, 1e-9);
}

TEST(TemporalError, DisoccludedPixelsAreLeftOut) {
  const Image3 black(4, 1);
  Image3 test = black;
  for (int c = 0; c < 3; ++c) {
    test[c](1, 0) = 1;
    test[c](2, 0) = 3;
  }
  Image1 depth = ConstantDepth(4, 1, 10.0f);
  Image1 previous_depth = ConstantDepth(4, 1, 10.0f);
  // Without the depth both count: (1/2 + 3/4) / 4.
  EXPECT_NEAR(Error(TemporalError(test, black, black, black, kNoMotion, kNoDepth, kNoDepth, false)),
              1.25 / 4, 1e-9);
  // An object stood before pixel 2.
  previous_depth(2, 0) = 5.0f;
  EXPECT_NEAR(
      Error(TemporalError(test, black, black, black, kNoMotion, depth, previous_depth, false)),
      0.5 / 3, 1e-9);
  // Within 5 % of 10: visible. The sky behind was there before, too.
  previous_depth(2, 0) = 10.4f;
  depth(3, 0) = kInfinity;
  previous_depth(3, 0) = kInfinity;
  EXPECT_NEAR(
      Error(TemporalError(test, black, black, black, kNoMotion, depth, previous_depth, false)),
      1.25 / 4, 1e-9);
  // An object that now shows sky, and depths that are no numbers.
  depth(0, 0) = kInfinity;
  depth(3, 0) = kNan;
  EXPECT_NEAR(
      Error(TemporalError(test, black, black, black, kNoMotion, depth, previous_depth, false)),
      1.25 / 2, 1e-9);
}

TEST(TemporalError, ValuesThatAreNotFiniteAreLeftOut) {
  const Image3 black(4, 1);
  const Image3 one = ConstantPicture(4, 1, {1, 1, 1});
  Image3 test = one;
  test[1](0, 0) = kNan;
  Image3 previous_reference = black;
  previous_reference[2](1, 0) = kInfinity;
  Image2 motion = ConstantMotion(4, 1, 0, 0);
  motion[1](2, 0) = kNan;
  EXPECT_NEAR(Error(TemporalError(test, black, black, previous_reference, motion, kNoDepth,
                                  kNoDepth, false)),
              0.5, 1e-9);
}

TEST(TemporalError, IsNoNumberWhereNoHistoryIsVisible) {
  const Image3 one = ConstantPicture(4, 3, {1, 1, 1});
  EXPECT_TRUE(std::isnan(Error(
      TemporalError(one, one, one, one, ConstantMotion(4, 3, 4, 0), kNoDepth, kNoDepth, false))));
  EXPECT_TRUE(std::isnan(Error(TemporalError(one, one, one, one, ConstantMotion(4, 3, 1e30f, 0),
                                             kNoDepth, kNoDepth, false))));
}

TEST(TemporalError, NamesWhatHasAnotherSize) {
  const Image3 small(4, 3);
  const Image3 large(5, 3);
  const Result<double> reference =
      TemporalError(small, small, large, small, kNoMotion, kNoDepth, kNoDepth, false);
  ASSERT_FALSE(reference.ok());
  EXPECT_EQ(reference.status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(reference.status().message(),
            "the reference is 5x3 pixels, but the test picture is 4x3");
  const Result<double> motion = TemporalError(
      small, small, small, small, ConstantMotion(4, 4, 0, 0), kNoDepth, kNoDepth, false);
  ASSERT_FALSE(motion.ok());
  EXPECT_THAT(motion.status().message(), HasSubstr("the motion is 4x4"));
  const Result<double> depth = TemporalError(small, small, small, small, kNoMotion,
                                             ConstantDepth(4, 3, 1), ConstantDepth(3, 3, 1), false);
  ASSERT_FALSE(depth.ok());
  EXPECT_THAT(depth.status().message(), HasSubstr("the previous depth is 3x3"));
  EXPECT_FALSE(
      TemporalError(Image3(), small, small, small, kNoMotion, kNoDepth, kNoDepth, false).ok());
}

}  // namespace
}  // namespace stillray::temporal_error_test
