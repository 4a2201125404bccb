// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/demodulate.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/colour_shared.h"
#include "stage_test.h"

namespace stillray::demodulate_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

using Version = decltype(&cpu::Demodulate);
constexpr Version kVersions[] = {&reference::Demodulate, &cpu::Demodulate};

NewLight MakeLight(int width, int height, bool within = false) {
  return {LumaImage3(width, height), Image1(width, height),
          within ? Image1(width, height) : Image1()};
}

Image3 Constant(float r, float g, float b, int width = 9, int height = 2) {
  const float rgb[3] = {r, g, b};
  return test::MakeImage(width, height, [&](int, int, int c) { return rgb[c]; });
}

TEST(Demodulate, SumOfLightsOverSumOfAlbedos) {
  const Image3 direct = Constant(0.75f, 0.5f, 1);
  const Image3 indirect = Constant(0.25f, 0.5f, 0);
  const Image3 diffuse = Constant(0.25f, 0.125f, 1);
  const Image3 specular = Constant(0.25f, 0.125f, 0);
  DemodulateInput in;
  in.radiance[0] = &direct;
  in.radiance[1] = &indirect;
  in.count = 2;
  in.albedo = {{&diffuse, &specular}, 2};
  for (const Version demodulate : kVersions) {
    NewLight out = MakeLight(9, 2);
    const DemodulateCounts counts = demodulate(in, &out);
    EXPECT_EQ(counts.non_finite + counts.negative, 0);
    // (1, 1, 1) / (0.5, 0.25, 1) = (2, 4, 1).
    EXPECT_NEAR(out.colour[0](8, 1), 0.2126f * 2 + 0.7152f * 4 + 0.0722f, 1e-6f);
    EXPECT_FLOAT_EQ(out.colour[1](8, 1), 2);
    EXPECT_FLOAT_EQ(out.colour[2](8, 1), 1);
    EXPECT_EQ(out.samples(8, 1), 1);
  }
}

TEST(Demodulate, BlackAlbedoIsTheFloor) {
  const Image3 light = Constant(1, 1, 1);
  const Image3 black = Constant(0, 0, 0);
  DemodulateInput in;
  in.radiance[0] = &light;
  in.count = 1;
  in.albedo = {{&black}, 1};
  for (const Version demodulate : kVersions) {
    NewLight out = MakeLight(9, 2);
    demodulate(in, &out);
    EXPECT_FLOAT_EQ(out.colour[1](0, 0), 1 / kAlbedoFloor);
  }
}

TEST(Demodulate, UnusableSamplesAreMissingAndCounted) {
  Image3 light = Constant(1, 1, 1);
  Image3 albedo = Constant(0.5f, 0.5f, 0.5f);
  Image1 samples(9, 2);
  samples.Fill(2);
  light[1](0, 0) = kNan;
  light[2](1, 0) = kInfinity;
  albedo[0](2, 0) = kNan;
  light[0](3, 0) = -0.5f;
  light[0](4, 0) = -0.001f;  // within the limit: zero
  samples(5, 0) = 0;
  light[1](6, 0) = kNan;  // not counted: no sample
  samples(6, 0) = 0;
  samples(7, 0) = kInfinity;
  DemodulateInput in;
  in.radiance[0] = &light;
  in.count = 1;
  in.albedo = {{&albedo}, 1};
  in.samples = &samples;
  in.negative_limit = 0.01f;
  for (const Version demodulate : kVersions) {
    NewLight out = MakeLight(9, 2);
    const DemodulateCounts counts = demodulate(in, &out);
    EXPECT_EQ(counts.non_finite, 3);
    EXPECT_EQ(counts.negative, 1);
    for (const int x : {0, 1, 2, 3, 5, 6, 7}) {
      EXPECT_EQ(out.samples(x, 0), 0) << x;
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(out.colour[c](x, 0), 0) << x;
      }
    }
    EXPECT_EQ(out.samples(4, 0), 2);
    EXPECT_EQ(out.colour[1](4, 0), 0);
    EXPECT_FLOAT_EQ(out.colour[2](4, 0), 2);
    EXPECT_EQ(out.samples(8, 0), 2);
    EXPECT_FLOAT_EQ(out.colour[0](8, 0), 2);
  }
}

TEST(Demodulate, VarianceWithinAPixelIsThatOfTheSignal) {
  // Samples of mean 1 and second moment 5 about white; the signal is divided by grey 0.5.
  const Image3 light = Constant(1, 1, 1);
  const Image3 grey = Constant(0.5f, 0.5f, 0.5f);
  Image1 moment(9, 2);
  moment.Fill(5);
  DemodulateInput in;
  in.radiance[0] = &light;
  in.second_moment[0] = &moment;
  in.count = 1;
  in.albedo = {{&grey}, 1};
  for (const Version demodulate : kVersions) {
    NewLight out = MakeLight(9, 2, true);
    demodulate(in, &out);
    EXPECT_NEAR(out.within(3, 1), (5 - 1) * 2 * 2, 1e-4f);
  }
}

TEST(Demodulate, VectorsMatchTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    Image3 direct = test::RandomImage(width, height, 1, 3);
    const Image3 indirect = test::RandomImage(width, height, 4, 2);
    const Image3 albedo = test::RandomImage(width, height, 7);
    const Image3 specular = test::RandomImage(width, height, 10, 0.1f);
    const Image1 moment = test::RandomPlane(width, height, 13, 40);
    const Image1 samples = test::MakePlane(
        width, height, [](int x, int y) { return std::floor(3 * test::RandomAt(x, y, 14)); });
    direct[2](width - 1, 0) = kNan;
    direct[0](0, height - 1) = -1;
    DemodulateInput in;
    in.radiance[0] = &direct;
    in.radiance[1] = &indirect;
    in.second_moment[1] = &moment;
    in.own_albedo[1] = &specular;
    in.count = 2;
    in.albedo = {{&albedo, &specular}, 2};
    in.samples = &samples;
    for (const bool rec601 : {false, true}) {
      in.luminance_rec601 = rec601;
      NewLight expected = MakeLight(width, height, true);
      NewLight got = MakeLight(width, height, true);
      const DemodulateCounts expected_counts = reference::Demodulate(in, &expected);
      const DemodulateCounts counts = cpu::Demodulate(in, &got);
      EXPECT_EQ(counts.non_finite, expected_counts.non_finite);
      EXPECT_EQ(counts.negative, expected_counts.negative);
      test::ExpectNear(got.colour, expected.colour, 1e-6);
      test::ExpectEqual(got.samples, expected.samples);
      // A difference of squares: relative to the moment.
      test::ExpectNear(got.within, expected.within, 1e-5, 1e-3);
    }
  });
}

}  // namespace
}  // namespace stillray::demodulate_test
