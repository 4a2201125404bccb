// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "quality/pictures.h"
#include "stillray/quality.h"

namespace stillray {
namespace {

using ::testing::HasSubstr;

/// A picture of one brightness per pixel.
Image3 Grey(int width, int height, const auto& value) {
  Image3 image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        image[c](x, y) = value(x, y);
      }
    }
  }
  return image;
}

// Two columns of object 3, one of object 8: errors by hand.
TEST(ObjectErrors, AreSumsOverTheirPixels) {
  const Image3 test = Grey(3, 2, [](int x, int) { return x == 2 ? 3.0f : 1.0f; });
  const Image3 reference = Grey(3, 2, [](int x, int y) {
    return x == 2 ? 1.0f : y == 0 ? 1.0f : 0.0f;
  });
  Image1 objects(3, 2);
  for (int y = 0; y < 2; ++y) {
    objects(0, y) = objects(1, y) = 3;
    objects(2, y) = 8.2f;  // stored as a float
  }
  const auto errors = CompareObjects(test, reference, false, objects);
  ASSERT_TRUE(errors.ok()) << errors.status().message();
  ASSERT_EQ(errors->size(), 2u);
  const ObjectErrors& a = (*errors)[0];
  EXPECT_EQ(a.object, 3);
  EXPECT_EQ(a.pixels, 4);
  EXPECT_NEAR(a.squared_error, 2 * 3 * 0.25, 1e-12);  // 1 / 2 in place of 0
  EXPECT_NEAR(a.rel_mse, 2 * 1 / 0.01, 1e-3);         // a mean over channels
  EXPECT_NEAR(a.luminance, 4, 1e-6);
  EXPECT_NEAR(a.reference_luminance, 2, 1e-6);
  const ObjectErrors& b = (*errors)[1];
  EXPECT_EQ(b.object, 8);
  EXPECT_EQ(b.pixels, 2);
  EXPECT_NEAR(b.squared_error, 2 * 3 * 0.0625, 1e-12);  // 3 / 4 in place of 1 / 2
  EXPECT_NEAR(b.rel_mse, 2 * 4 / 1.01, 1e-5);
}

// All objects together are the picture.
TEST(ObjectErrors, AddUpToThePicture) {
  constexpr int kWidth = 40;
  constexpr int kHeight = 30;
  const auto noise = [](int x, int y) { return static_cast<float>((x * 7 + y * 13) % 11) / 5; };
  Image3 test = Grey(kWidth, kHeight, noise);
  test[1](4, 5) = std::numeric_limits<float>::quiet_NaN();
  const Image3 reference =
      Grey(kWidth, kHeight, [](int x, int) { return 0.02f * static_cast<float>(x); });
  Image1 objects(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      objects(x, y) = static_cast<float>((x / 9 + y / 7) % 5);
    }
  }
  const auto errors = CompareObjects(test, reference, false, objects);
  ASSERT_TRUE(errors.ok()) << errors.status().message();
  EXPECT_EQ(errors->size(), 5u);
  ObjectErrors sum;
  for (const ObjectErrors& e : *errors) {
    sum += e;
  }
  const auto whole = CompareImages(test, reference, false);
  ASSERT_TRUE(whole.ok());
  const auto pixels = static_cast<double>(sum.pixels);
  EXPECT_EQ(sum.pixels, kWidth * kHeight - 1);
  EXPECT_NEAR(sum.flip / pixels, whole->flip, 1e-6);
  EXPECT_NEAR(sum.rel_mse / pixels, whole->rel_mse, 1e-4 * whole->rel_mse);
  EXPECT_NEAR(-10 * std::log10(sum.squared_error / (3 * pixels)), whole->psnr, 1e-6);
  EXPECT_NEAR(sum.luminance / sum.reference_luminance, whole->brightness, 1e-6);
}

TEST(ObjectErrors, SaysWhatIsWrong) {
  const Image3 picture = Grey(4, 4, [](int, int) { return 1.0f; });
  EXPECT_THAT(CompareObjects(picture, picture, false, Image1(4, 3)).status().message(),
              HasSubstr("the objects are 4x3 pixels, the pictures 4x4"));
  EXPECT_FALSE(CompareObjects(picture, Image3(3, 4), false, Image1(4, 4)).ok());
}

}  // namespace
}  // namespace stillray
