// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/light_confidence.h"

#include <limits>

#include <gtest/gtest.h>

namespace stillray::io::light_confidence_test {
namespace {

constexpr int kSize = 32;

Image3 Grey(float value) {
  Image3 image(kSize, kSize);
  for (int c = 0; c < 3; ++c) {
    image[c].Fill(value);
  }
  return image;
}

/// Smoke in the right half alone.
Image3 RightHalf(float value) {
  Image3 image(kSize, kSize);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = kSize / 2; x < kSize; ++x) {
        image[c](x, y) = value;
      }
    }
  }
  return image;
}

Image1 Samples(float number) {
  Image1 samples(kSize, kSize);
  samples.Fill(number);
  return samples;
}

TEST(VolumeConfidence, FallsWithTheNumberOfSamples) {
  const Image3 light = Grey(1);
  EXPECT_EQ(VolumeConfidence(light, light, Image1())(9, 9), 1.0f);
  EXPECT_EQ(VolumeConfidence(light, light, Samples(1))(9, 9), 1.0f);
  EXPECT_EQ(VolumeConfidence(light, light, Samples(0.25f))(9, 9), 1.0f);
  EXPECT_NEAR(VolumeConfidence(light, light, Samples(2))(9, 9), 0.675f, 1e-6f);
  EXPECT_NEAR(VolumeConfidence(light, light, Samples(4))(0, 31), 0.35f, 1e-6f);
  EXPECT_NEAR(VolumeConfidence(light, light, Samples(64))(31, 0), 0.35f, 1e-6f);
}

TEST(VolumeConfidence, OnlyWhereLightIsAVolumes) {
  const Image1 confidence = VolumeConfidence(RightHalf(0.5f), Grey(1), Samples(16));
  EXPECT_EQ(confidence(5, 16), 1.0f);
  EXPECT_NEAR(confidence(28, 16), 0.35f, 1e-6f);
  // An eighth of the light has half of the effect of a quarter.
  const Image1 faint = VolumeConfidence(RightHalf(0.125f), Grey(1), Samples(16));
  EXPECT_NEAR(faint(28, 16), 1 - 0.5f * 0.65f, 1e-6f);
}

TEST(VolumeConfidence, InvalidAndBlackLight) {
  Image3 light = Grey(1);
  light[1](3, 3) = std::numeric_limits<float>::quiet_NaN();
  light[2](4, 4) = -5;
  const Image1 confidence = VolumeConfidence(light, light, Samples(4));
  EXPECT_NEAR(confidence(3, 3), 0.35f, 1e-6f);
  EXPECT_EQ(VolumeConfidence(Grey(0), Grey(0), Samples(4))(9, 9), 1.0f);
}

/// Normals of this length.
Image3 Normals(float length) {
  Image3 normal(kSize, kSize);
  normal[2].Fill(-length);
  return normal;
}

Image2 Motion(float x, float y) {
  Image2 motion(kSize, kSize);
  motion[0].Fill(x);
  motion[1].Fill(y);
  return motion;
}

TEST(MixedLoss, GrowsWithWhatNormalsLackAndTheSamples) {
  EXPECT_EQ(MixedLoss(Normals(1), Samples(16))(9, 9), 0.0f);
  EXPECT_EQ(MixedLoss(Normals(0.96f), Samples(16))(9, 9), 0.0f);
  EXPECT_NEAR(MixedLoss(Normals(0.9f), Samples(16))(9, 9), 0.3f, 1e-5f);
  EXPECT_NEAR(MixedLoss(Normals(0.5f), Samples(16))(9, 9), 0.6f, 1e-5f);
  EXPECT_NEAR(MixedLoss(Normals(0.5f), Samples(4))(0, 31), 0.3f, 1e-5f);
  EXPECT_NEAR(MixedLoss(Normals(0.5f), Samples(1024))(31, 0), 0.65f, 1e-5f);
  EXPECT_EQ(MixedLoss(Normals(0.5f), Image1())(9, 9), 0.0f);
}

TEST(MixedLoss, OutlinesAndPixelsWithoutSurfaceHardlyCount) {
  Image3 normal = Normals(1);
  for (int y = 0; y < kSize; ++y) {
    normal[2](12, y) = -0.8f;  // one line of mixed pixels
  }
  EXPECT_EQ(MixedLoss(normal, Samples(16))(12, 9), 0.0f);
  normal = Normals(0);
  normal[2](4, 4) = -0.5f;
  normal[2](5, 4) = std::numeric_limits<float>::quiet_NaN();
  const Image1 loss = MixedLoss(normal, Samples(16));
  EXPECT_NEAR(loss(4, 4), 0.6f, 1e-5f);  // sky does not count
  EXPECT_EQ(loss(20, 20), 0.0f);
}

TEST(ConfidenceInMotion, WhatStandsStillKeepsItsHistory) {
  const Image1 loss = MixedLoss(Normals(0.5f), Samples(16));
  EXPECT_EQ(ConfidenceInMotion(loss, Motion(0, 0))(9, 9), 1.0f);
  EXPECT_NEAR(ConfidenceInMotion(loss, Motion(0.125f, 0))(9, 9), 0.7f, 1e-5f);
  EXPECT_NEAR(ConfidenceInMotion(loss, Motion(0, -0.25f))(9, 9), 0.4f, 1e-5f);
  EXPECT_NEAR(ConfidenceInMotion(loss, Motion(3, 4))(9, 9), 0.4f, 1e-5f);
}

}  // namespace
}  // namespace stillray::io::light_confidence_test
