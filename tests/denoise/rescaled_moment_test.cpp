// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/rescaled_moment_shared.h"

#include <gtest/gtest.h>

namespace stillray::rescaled_moment_test {
namespace {

// Grey albedos: the moment of light l / a is that of l, divided by the square of a.
TEST(RescaledMoment, IsExactForGreyAlbedos) {
  // Light 1 and 3, of luminance 2 in the mean and 5 in the mean of the squares.
  const float moment = 5.0f / (0.5f * 0.5f);
  EXPECT_FLOAT_EQ(RescaledMoment(moment, vec3(2.0f), vec3(0.5f), vec3(0.25f)),
                  5.0f / (0.25f * 0.25f));
  EXPECT_FLOAT_EQ(RescaledMoment(moment, vec3(2.0f), vec3(0.5f), vec3(0.5f)), moment);
}

TEST(RescaledMoment, DividesByAlbedosAboveTheFloor) {
  EXPECT_FLOAT_EQ(RescaledMoment(5.0f, vec3(2.0f), vec3(1.0f), vec3(0.0f)), 5.0f * 1e4f);
}

// The mean is that of the light divided by each colour: red light 1, albedo from (1, 1, 1) to
// (0.5, 1, 1). Means 0.2126 and 0.4252; the variance 0.5 is scaled by 1 / 0.8937^2.
TEST(RescaledMoment, ColoursChangeTheMean) {
  const float moment = 0.5f + 0.2126f * 0.2126f;
  EXPECT_NEAR(RescaledMoment(moment, vec3(1, 0, 0), vec3(1.0f), vec3(0.5f, 1, 1)),
              0.5 / (0.8937 * 0.8937) + 0.4252 * 0.4252, 1e-6);
}

// Rounding may leave a moment below the square of its mean: no negative variance.
TEST(RescaledMoment, VarianceIsNotNegative) {
  EXPECT_FLOAT_EQ(RescaledMoment(3.9f, vec3(2.0f), vec3(1.0f), vec3(0.5f)), 16.0f);
}

}  // namespace
}  // namespace stillray::rescaled_moment_test
