// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "pictures.h"
#include "stillray/quality.h"

namespace stillray::light_change_test {
namespace {

using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

const Image1 kNoDepth;
const Image2 kNoMotion;

double Change(const Image3& test, const Image3& previous_test, const Image3& reference,
              const Image3& previous_reference, bool display = false,
              const Image2& motion = kNoMotion) {
  const Result<LightChange> change = MeasureLightChange(
      test, previous_test, reference, previous_reference, motion, kNoDepth, kNoDepth, display);
  EXPECT_TRUE(change.ok()) << change.status().message();
  return change.ok() ? change->Share() : -1;
}

/// Grey that lies at `compressed` on the curve of radiance.
Image3 Grey(int width, int height, float compressed) {
  const float value = compressed / (1 - compressed);
  return ConstantPicture(width, height, {value, value, value});
}

void SetPixel(int x, int y, float value, Image3* image) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value;
  }
}

TEST(LightChange, ThePictureThatMakesAllOfItHasOne) {
  const Image3 before = NoisePicture(40, 24, 1);
  const Image3 after = NoisePicture(40, 24, 2, 2.0f);
  EXPECT_EQ(Change(after, before, after, before), 1);
  EXPECT_EQ(Change(after, before, after, before, true), 1);
}

// The reference goes from 0.3 to 0.5 on the curve.
TEST(LightChange, IsTheShareOfTheStepThatThePictureMakes) {
  const Image3 before = Grey(24, 16, 0.3f);
  const Image3 after = Grey(24, 16, 0.5f);
  EXPECT_NEAR(Change(Grey(24, 16, 0.4f), before, after, before), 0.5, 1e-6);
  EXPECT_EQ(Change(before, before, after, before), 0);
  EXPECT_NEAR(Change(Grey(24, 16, 0.6f), before, after, before), 1.5, 1e-6);
  EXPECT_NEAR(Change(Grey(24, 16, 0.2f), before, after, before), -0.5, 1e-6);
  // Constant errors do not matter.
  EXPECT_NEAR(Change(Grey(24, 16, 0.8f), Grey(24, 16, 0.7f), after, before), 0.5, 1e-6);
}

TEST(LightChange, DisplayPicturesCountAsTheirFilesValues) {
  // Linear values of the sRGB values 0.2, 0.3 and 0.4.
  const Image3 low = ConstantPicture(24, 16, {0.0331048f, 0.0331048f, 0.0331048f});
  const Image3 middle = ConstantPicture(24, 16, {0.0732389f, 0.0732389f, 0.0732389f});
  const Image3 high = ConstantPicture(24, 16, {0.1328683f, 0.1328683f, 0.1328683f});
  EXPECT_NEAR(Change(middle, low, high, low, true), 0.5, 1e-4);
}

// One block changes by 0.2, one by 0.1; the picture makes the first change and not the second.
TEST(LightChange, IsALeastSquaresSlope) {
  const Image3 before = Grey(24, 8, 0.3f);
  Image3 after = before;
  Image3 test = before;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      SetPixel(x, y, 1, &after);
      SetPixel(x, y, 1, &test);
      SetPixel(x + 8, y, 0.4f / 0.6f, &after);
    }
  }
  EXPECT_NEAR(Change(test, before, after, before), 0.04 / 0.05, 1e-6);
}

// A step of 0.2 on the curve, of which the picture makes 0.05.
TEST(LightChange, HoldsMeansOverPixels) {
  const Image3 before = Grey(24, 16, 0.3f);
  const Result<LightChange> change =
      MeasureLightChange(Grey(24, 16, 0.35f), before, Grey(24, 16, 0.5f), before, kNoMotion,
                         kNoDepth, kNoDepth, false);
  ASSERT_TRUE(change.ok());
  EXPECT_NEAR(change->product, 0.01, 1e-6);
  EXPECT_NEAR(change->square, 0.04, 1e-6);
  EXPECT_NEAR(change->Share(), 0.25, 1e-6);
  EXPECT_TRUE(std::isnan(LightChange().Share()));
}

TEST(LightChange, IsNoNumberWhereTheLightIsSteady) {
  const Image3 reference = NoisePicture(32, 32, 1);
  EXPECT_TRUE(
      std::isnan(Change(NoisePicture(32, 32, 2), NoisePicture(32, 32, 3), reference, reference)));
  // The limit is a root mean square of 0.001.
  const Image3 before = Grey(32, 32, 0.5f);
  EXPECT_TRUE(std::isnan(Change(before, before, Grey(32, 32, 0.5009f), before)));
  EXPECT_EQ(Change(before, before, Grey(32, 32, 0.5011f), before), 0);
}

// Half the step of 0.01 on the curve, under noise in all four pictures: 0.06 in the change of a
// pixel. Over the means of whole blocks, a regression on the noisy reference would find about 0.31.
TEST(LightChange, NoiseDoesNotShiftIt) {
  const auto noisy = [](float level, uint32_t seed) {
    const float base = level / (1 - level);
    return Blend(ConstantPicture(512, 512, {base - 0.4f, base - 0.4f, base - 0.4f}),
                 NoisePicture(512, 512, seed), 0.8f);
  };
  const Image3 before = noisy(0.5f, 1), after = noisy(0.51f, 2);
  const Image3 test_before = noisy(0.5f, 3), test = noisy(0.505f, 4);
  EXPECT_NEAR(Change(test, test_before, after, before), 0.5, 0.05);
  EXPECT_NEAR(Change(after, before, after, before), 1, 1e-12);
}

// As the definition says, with motion by fractions of a pixel and blocks that the border cuts.
TEST(LightChange, AgreesWithTheDefinitionOnNoise) {
  constexpr int kWidth = 29;
  constexpr int kHeight = 19;
  const Image3 test = NoisePicture(kWidth, kHeight, 1, 3.0f);
  const Image3 previous_test = NoisePicture(kWidth, kHeight, 2);
  const Image3 reference = NoisePicture(kWidth, kHeight, 3, 4.0f);
  const Image3 previous_reference = NoisePicture(kWidth, kHeight, 4);
  const auto light = [](const Image3& image, int x, int y) {
    const double l = 0.2126 * image[0](x, y) + 0.7152 * image[1](x, y) + 0.0722 * image[2](x, y);
    return l / (1 + l);
  };
  // The history is 1.25 pixels to the left and 0.5 below.
  const auto change = [&light](const Image3& now, const Image3& before, int x, int y) {
    const int x0 = std::max(x - 2, 0);  // column 1 lies at -0.25: within the first pixel's area
    const int y1 = std::min(y + 1, kHeight - 1);
    return light(now, x, y) -
           0.5 * (0.25 * light(before, x0, y) + 0.75 * light(before, x - 1, y) +
                  0.25 * light(before, x0, y1) + 0.75 * light(before, x - 1, y1));
  };
  double product = 0, square = 0;
  for (int by = 0; by < kHeight; by += 8) {
    for (int bx = 0; bx < kWidth; bx += 8) {
      std::array<double, 2> t = {}, r = {}, n = {};
      for (int y = by; y < std::min(by + 8, kHeight); ++y) {
        for (int x = std::max(bx, 1); x < std::min(bx + 8, kWidth); ++x) {
          const size_t half = x - bx < 4 ? 0 : 1;
          t[half] += change(test, previous_test, x, y);
          r[half] += change(reference, previous_reference, x, y);
          ++n[half];
        }
      }
      if (n[0] > 0 && n[1] > 0) {
        const double weight = n[0] + n[1];
        product += weight * (t[0] / n[0] * r[1] / n[1] + t[1] / n[1] * r[0] / n[0]);
        square += weight * 2 * r[0] / n[0] * r[1] / n[1];
      }
    }
  }
  Image2 motion(kWidth, kHeight);
  motion[0].Fill(-1.25f);
  motion[1].Fill(0.5f);
  EXPECT_NEAR(Change(test, previous_test, reference, previous_reference, false, motion),
              product / square, 1e-6);
}

// The left half of the picture makes the whole step, the right half nothing of it.
TEST(LightChange, HiddenAndInvalidPixelsAreLeftOut) {
  const Image3 before = Grey(32, 8, 0.3f);
  const Image3 after = Grey(32, 8, 0.5f);
  Image3 test = after;
  for (int y = 0; y < 8; ++y) {
    for (int x = 16; x < 32; ++x) {
      SetPixel(x, y, before[0](x, y), &test);
    }
  }
  EXPECT_NEAR(Change(test, before, after, before), 0.5, 1e-6);
  // The right half was behind something else.
  Image1 depth(32, 8), previous_depth(32, 8);
  depth.Fill(10);
  previous_depth.Fill(10);
  for (int y = 0; y < 8; ++y) {
    for (int x = 16; x < 32; ++x) {
      previous_depth(x, y) = 5;
    }
  }
  const Result<LightChange> visible =
      MeasureLightChange(test, before, after, before, kNoMotion, depth, previous_depth, false);
  ASSERT_TRUE(visible.ok());
  EXPECT_NEAR(visible->Share(), 1, 1e-6);
  // Or its history is outside the picture, or its values are not finite.
  Image2 motion(32, 8);
  Image3 invalid = test, invalid_before = before;
  for (int y = 0; y < 8; ++y) {
    for (int x = 16; x < 32; ++x) {
      motion[0](x, y) = 32;
      invalid[1](x, y) = kNan;
      invalid_before[2](x, y) = kNan;
    }
  }
  EXPECT_NEAR(Change(test, before, after, before, false, motion), 1, 1e-6);
  EXPECT_NEAR(Change(invalid, before, after, before), 1, 1e-6);
  EXPECT_NEAR(Change(test, before, after, invalid_before), 1, 1e-6);
  motion[0].Fill(32);
  EXPECT_TRUE(std::isnan(Change(test, before, after, before, false, motion)));
}

TEST(LightChange, NamesWhatHasAnotherSize) {
  const Image3 small(4, 3);
  const Result<LightChange> change =
      MeasureLightChange(small, small, small, Image3(5, 3), kNoMotion, kNoDepth, kNoDepth, false);
  ASSERT_FALSE(change.ok());
  EXPECT_EQ(change.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(change.status().message(), HasSubstr("the previous reference is 5x3"));
}

TEST(LightChange, AnyNumberOfThreadsGivesTheSameBits) {
  const auto run = [](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return Change(NoisePicture(300, 150, 1, 2.0f), NoisePicture(300, 150, 2),
                  NoisePicture(300, 150, 3, 3.0f), NoisePicture(300, 150, 4));
  };
  const double one = run(1);
  const double four = run(4);
  EXPECT_EQ(std::memcmp(&one, &four, sizeof(one)), 0);
}

}  // namespace
}  // namespace stillray::light_change_test
