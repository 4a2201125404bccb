// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::compare_images_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::array<ErrorMap, 4> kAllMaps = {ErrorMap::kFlip, ErrorMap::kHdrFlip,
                                              ErrorMap::kRelativeSquaredError, ErrorMap::kSsim};

TEST(CompareImages, SizesMustAgree) {
  const Result<ImageMetrics> metrics = CompareImages(Image3(4, 3), Image3(3, 4), false);
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(metrics.status().message(), "the test picture is 4x3 pixels, but the reference is 3x4");
}

TEST(CompareImages, PsnrAloneIsThatOfAllMeasures) {
  Image3 reference(2, 1);
  Image3 test(2, 1);
  for (int c = 0; c < 3; ++c) {
    reference[c](0, 0) = 1.0f;
    test[c](0, 0) = 3.0f;
  }
  // On the curve x / (1 + x): 1/2 and 3/4 in one of two pixels.
  const Result<double> psnr = MeasurePsnr(test, reference);
  ASSERT_TRUE(psnr.ok());
  EXPECT_NEAR(*psnr, -10 * std::log10(0.25 * 0.25 / 2), 1e-9);
  EXPECT_EQ(*psnr, CompareImages(test, reference, false)->psnr);
  EXPECT_EQ(MeasurePsnr(Image3(4, 3), Image3(3, 4)).status().code(), StatusCode::kInvalidArgument);
}

TEST(CompareImages, ChannelsMustAgree) {
  Image3 odd(4, 3);
  odd[2] = Image1(4, 4);
  const Result<ImageMetrics> metrics = CompareImages(Image3(4, 3), odd, false);
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.status().message(),
            "reference picture: channel 2 is 4x4 pixels, channel 0 is 4x3");
}

TEST(CompareImages, EmptyPicturesAreRefused) {
  const Result<ImageMetrics> metrics = CompareImages(Image3(), Image3(), true);
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.status().code(), StatusCode::kInvalidArgument);
}

TEST(CompareImages, NothingFiniteIsAnError) {
  const Image3 nan = ConstantPicture(3, 3, {kNan, 0, 0});
  const Result<ImageMetrics> metrics = CompareImages(nan, Image3(3, 3), false);
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.status().code(), StatusCode::kBadData);
}

TEST(CompareImages, HdrFlipNeedsRadiance) {
  const Image3 picture = ScenePicture(8, 8);
  const Result<Image1> map = MakeErrorMap(picture, picture, true, ErrorMap::kHdrFlip);
  ASSERT_FALSE(map.ok());
  EXPECT_EQ(map.status().code(), StatusCode::kInvalidArgument);
  const Result<ImageMetrics> metrics = CompareImages(picture, picture, true);
  ASSERT_TRUE(metrics.ok());
  EXPECT_EQ(metrics->hdr_flip, 0);
}

// Pixels that are not finite must neither count nor reach others through filter windows: with them
// in otherwise equal pictures there is no error at all.
TEST(CompareImages, PixelsThatAreNotFiniteAreCountedAndLeftOut) {
  const Image3 reference = ScenePicture(40, 30);
  Image3 test = reference;
  test[0](20, 15) = kNan;
  test[1](21, 15) = kInfinity;
  Image3 broken_reference = reference;
  broken_reference[2](5, 5) = kInfinity;
  broken_reference[2](20, 15) = kNan;  // broken in both pictures
  const Result<ImageMetrics> metrics = CompareImages(test, broken_reference, false);
  ASSERT_TRUE(metrics.ok());
  EXPECT_EQ(metrics->non_finite, 3);
  EXPECT_EQ(metrics->psnr, kInfinity);
  EXPECT_EQ(metrics->ssim, 1);
  EXPECT_EQ(metrics->rel_mse, 0);
  EXPECT_EQ(metrics->flip, 0);
  EXPECT_EQ(metrics->hdr_flip, 0);
  EXPECT_NEAR(metrics->brightness, 1, 1e-12);
  for (const ErrorMap which : kAllMaps) {
    const Result<Image1> map = MakeErrorMap(test, broken_reference, false, which);
    ASSERT_TRUE(map.ok());
    int not_a_number = 0;
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        not_a_number += std::isnan((*map)(x, y)) ? 1 : 0;
      }
    }
    EXPECT_EQ(not_a_number, 3);
    EXPECT_TRUE(std::isnan((*map)(5, 5)));
    EXPECT_TRUE(std::isnan((*map)(20, 15)));
    EXPECT_TRUE(std::isnan((*map)(21, 15)));
  }
}

// Where the reference is broken both pictures are black to the windows around; where only the test
// is, both hold the reference.
TEST(CompareImages, PixelsThatAreNotFiniteLookTheSameInBothPictures) {
  const Image3 reference = ScenePicture(30, 20, 2.0f);
  const Image3 test = Blend(reference, NoisePicture(30, 20, 3), 0.5f);
  Image3 broken_test = test, broken_reference = reference;
  Image3 mended_test = test, mended_reference = reference;
  broken_reference[1](12, 10) = kInfinity;
  broken_test[0](17, 9) = kInfinity;
  for (int c = 0; c < 3; ++c) {
    mended_test[c](12, 10) = 0;
    mended_reference[c](12, 10) = 0;
    mended_test[c](17, 9) = reference[c](17, 9);
  }
  for (const ErrorMap which : {ErrorMap::kFlip, ErrorMap::kSsim}) {
    // As display pictures, whose exposure does not depend on the pixels that are left out.
    const Result<Image1> broken = MakeErrorMap(broken_test, broken_reference, true, which);
    const Result<Image1> mended = MakeErrorMap(mended_test, mended_reference, true, which);
    ASSERT_TRUE(broken.ok() && mended.ok());
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 30; ++x) {
        if (!std::isnan((*broken)(x, y))) {
          ASSERT_EQ((*broken)(x, y), (*mended)(x, y)) << x << ", " << y;
        }
      }
    }
  }
}

TEST(CompareImages, MeansAreThoseOfTheMaps) {
  const Image3 reference = ScenePicture(50, 20, 4.0f);
  const Image3 test = Blend(reference, NoisePicture(50, 20, 1), 1.0f);
  const Result<ImageMetrics> metrics = CompareImages(test, reference, false);
  ASSERT_TRUE(metrics.ok());
  const auto mean = [&](ErrorMap which) {
    const Result<Image1> map = MakeErrorMap(test, reference, false, which);
    double sum = 0;
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 50; ++x) {
        sum += (*map)(x, y);
      }
    }
    return sum / (50 * 20);
  };
  EXPECT_NEAR(mean(ErrorMap::kFlip), metrics->flip, 1e-12);
  EXPECT_NEAR(mean(ErrorMap::kHdrFlip), metrics->hdr_flip, 1e-12);
  EXPECT_NEAR(1 - mean(ErrorMap::kSsim), metrics->ssim, 1e-12);
  EXPECT_GT(metrics->hdr_flip, metrics->flip);
}

TEST(CompareImages, AnyNumberOfThreadsGivesTheSameBits) {
  const Image3 reference = ScenePicture(300, 150, 4.0f);
  const Image3 test = Blend(reference, NoisePicture(300, 150, 2), 1.0f);
  const auto run = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Result<ImageMetrics> metrics = CompareImages(test, reference, false);
    EXPECT_TRUE(metrics.ok());
    return std::array<double, 11>{metrics->psnr,
                                  metrics->ssim,
                                  metrics->rel_mse,
                                  metrics->flip,
                                  metrics->hdr_flip,
                                  metrics->brightness,
                                  metrics->bright_specks,
                                  metrics->dark_specks,
                                  metrics->worst_share,
                                  metrics->brightness_lowest,
                                  metrics->brightness_highest};
  };
  const std::array<double, 11> one = run(1);
  const std::array<double, 11> four = run(4);
  EXPECT_EQ(std::memcmp(one.data(), four.data(), sizeof(one)), 0);
}

}  // namespace
}  // namespace stillray::compare_images_test
