// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas that only the shaders use, against numbers worked out by hand or in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/suppress_fireflies_shared.h"
#include "denoise/vulkan/edge_exponent_shared.h"
#include "denoise/vulkan/exposure_shared.h"

namespace stillray::formulas_test {
namespace {

TEST(EdgeExponents, AreTheLogarithmsOfTheWeights) {
  for (const float cosine : {1.0f, 0.999f, 0.9f, 0.5f, 0.01f}) {
    for (const float sigma_n : {1.0f, 8.0f, 64.0f}) {
      const double weight = std::pow(static_cast<double>(cosine), static_cast<double>(sigma_n));
      EXPECT_NEAR(std::exp2(static_cast<double>(
                      NormalExponent2(cosine, NormalScale(sigma_n, false), false))),
                  weight, 1e-5);
      // To second order about 1: 2c - c^2/2 - 3/2.
      const double c = cosine;
      EXPECT_NEAR(NormalExponent2(cosine, NormalScale(sigma_n, true), true) * std::log(2.0),
                  sigma_n * (2 * c - c * c / 2 - 1.5), 1e-5 * sigma_n);
    }
  }
  for (const float cosine : {0.0f, -0.0f, -0.3f, -1.0f}) {  // surfaces that face away
    EXPECT_LT(std::exp2(NormalExponent2(cosine, 1.0f, false)), kMinAtrousWeight);
    EXPECT_EQ(std::exp2(NormalExponent2(cosine, 64.0f, false)), 0.0f);
    EXPECT_EQ(std::exp2(NormalExponent2(cosine, 0.0f, false)), 1.0f);  // a weight that is off
  }
}

// Against the formulas of the papers in double precision, with depths: SVGF eq. 3 and the distance
// from a plane.
TEST(EdgeExponents, OfDepthAreThoseOfThePapers) {
  const double log2_e = 1.0 / std::log(2.0);
  for (const float zp : {0.01f, 1.0f, 7.5f, 3e4f}) {
    for (const float ratio : {1.0f, 1.0001f, 0.9f, 1.5f, 20.0f}) {
      for (const float slope : {0.0f, 0.003f, -0.2f}) {  // of the inverse depth, relative to it
        const float ip = 1.0f / zp;
        const float iq = ip / ratio;
        const float change = slope * ip;
        const double p = 1.0 / static_cast<double>(ip);
        const double q = 1.0 / static_cast<double>(iq);
        const double steepness = std::abs(static_cast<double>(change)) * p * p;
        const double gradient = std::abs(p - q) / (2.0 * steepness + 0.01 * p) * log2_e;
        EXPECT_NEAR(GradientDepthExponent2(ip, iq, change * (2.0f / kExponentsOfE / ip),
                                           0.01f / kExponentsOfE),
                    gradient, 1e-4 * gradient + 2e-5);
        const double plane =
            std::abs(static_cast<double>(ip) + static_cast<double>(change) - 1.0 / q) / (0.02 / p) *
            log2_e;
        const float scale = kExponentsOfE / 0.02f * (1.0f / ip);
        EXPECT_NEAR(PlaneDepthExponent2(ip + change, iq, scale), plane, 1e-4 * plane + 2e-5);
      }
    }
  }
}

TEST(Exposure, IsAPowerOfTwoNearAnEighth) {
  EXPECT_EQ(ChooseExposure(0, 1.0f), 0.125f);
  EXPECT_EQ(ChooseExposure(0, 1.99f), 0.125f);
  EXPECT_EQ(ChooseExposure(0, 2.0f), 0.0625f);
  EXPECT_EQ(ChooseExposure(0, 0.3f), 0.5f);
  for (const float mean : {1e-30f, 3e-7f, 0.02f, 7.0f, 5e8f, 1e30f}) {
    const float exposure = ChooseExposure(0, mean);
    int exponent = 0;
    EXPECT_EQ(std::frexp(exposure, &exponent), 0.5f) << mean;
    if (mean > 1e-28f && mean < 1e28f) {
      EXPECT_GE(mean * exposure, 0.125f) << mean;
      EXPECT_LT(mean * exposure, 0.25f) << mean;
    }
  }
}

TEST(Exposure, StaysUnlessTheLightLeavesItFar) {
  EXPECT_EQ(ChooseExposure(0.125f, 8.0f), 0.125f);     // a level of 1
  EXPECT_EQ(ChooseExposure(0.125f, 8.1f), 0.015625f);  // above
  EXPECT_EQ(ChooseExposure(0.125f, 0.125f), 0.125f);   // a level of 1/64
  EXPECT_EQ(ChooseExposure(0.125f, 0.12f), 2.0f);      // below: 0.12 is in 1/16..1/8
  EXPECT_EQ(ChooseExposure(0.125f, 0.0f), 0.125f);     // black has no information
  EXPECT_EQ(ChooseExposure(0.0f, 0.0f), 1.0f);
}

TEST(Fireflies, CompressionIsUndone) {
  for (const float l : {0.0f, 0.5f, 3.0f, 32.0f, 50.0f, 1000.0f, 20000.0f}) {
    const float compressed = l * CompressScale(l);
    EXPECT_NEAR(compressed * ExpandScale(compressed), l, 1e-3f * l);
    EXPECT_LT(compressed, 64.0f);
  }
  EXPECT_EQ(CompressScale(32), 1.0f);
  EXPECT_FLOAT_EQ(CompressScale(64), 0.75f);
  EXPECT_FLOAT_EQ(ExpandScale(48), 4.0f / 3);
  EXPECT_FLOAT_EQ(64 * ExpandScale(64), 32 * 1000);
  EXPECT_EQ(ClampScale(8, 2), 0.25f);
  EXPECT_EQ(ClampScale(2, 8), 1.0f);
}

TEST(LimitHistory, CompressionScaleFollowsInSteps) {
  EXPECT_EQ(CompressionScale(1.0f, 1.9f), 1.0f);
  EXPECT_EQ(CompressionScale(1.0f, 0.6f), 1.0f);
  EXPECT_EQ(CompressionScale(1.0f, 2.0f), 2.0f);
  EXPECT_EQ(CompressionScale(1.0f, 0.4f), 0.4f);
  EXPECT_EQ(CompressionScale(0.0f, 3.0f), 3.0f);
  EXPECT_EQ(CompressionScale(0.0f, 0.0f), 1e-20f);
}

}  // namespace
}  // namespace stillray::formulas_test
