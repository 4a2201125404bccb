// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/remodulate.h"

#include <array>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "denoise/stages/demodulate.h"
#include "stage_test.h"

namespace stillray::remodulate_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

using Version = decltype(&cpu::Remodulate);
constexpr Version kVersions[] = {&reference::Remodulate, &cpu::Remodulate};

template <typename Image = Image3>
Image Constant(float a, float b, float c) {
  const float value[3] = {a, b, c};
  return test::MakeImage<Image>(9, 2, [&](int, int, int channel) { return value[channel]; });
}

TEST(Remodulate, InverseOfDemodulate) {
  const Image3 radiance = test::RandomImage(9, 2, 1, 4);
  const Image3 albedo = test::RandomImage(9, 2, 5);
  for (const bool rec601 : {false, true}) {
    DemodulateInput in;
    in.radiance[0] = &radiance;
    in.count = 1;
    in.albedo = {{&albedo}, 1};
    in.luminance_rec601 = rec601;
    NewLight light = {LumaImage3(9, 2), Image1(9, 2), Image1()};
    reference::Demodulate(in, &light);
    const SignalLight signal = {&light.colour, in.albedo};
    for (const Version remodulate : kVersions) {
      Image3 picture(9, 2);
      EXPECT_EQ(remodulate({&signal, 1}, {}, {rec601, false}, &picture), 0);
      // Green is a difference of the luminance and the others.
      test::ExpectNear(picture, radiance, 1e-5, 1e-5);
    }
  }
}

TEST(Remodulate, AddsSignalsAndUnfilteredLight) {
  const LumaImage3 light = Constant<LumaImage3>(1, 1, 1);  // grey of luminance 1
  const Image3 half = Constant(0.5f, 0.5f, 0.5f);
  const Image3 quarter = Constant(0.25f, 0.25f, 0.25f);
  const Image3 emission = Constant(3, 0, 1);
  const std::vector<SignalLight> signals = {{&light, {{&half, &quarter}, 2}}, {&light, {}}};
  const std::array<const Image3*, 1> unfiltered = {&emission};
  for (const Version remodulate : kVersions) {
    for (const bool add : {false, true}) {
      Image3 picture = Constant(10, 20, 30);
      EXPECT_EQ(remodulate(signals, unfiltered, {false, add}, &picture), 0);
      EXPECT_NEAR(picture[0](8, 1), 0.75f + 1 + 3 + (add ? 10 : 0), 1e-5f);
      EXPECT_NEAR(picture[1](8, 1), 0.75f + 1 + (add ? 20 : 0), 1e-5f);
      EXPECT_NEAR(picture[2](8, 1), 0.75f + 1 + 1 + (add ? 30 : 0), 1e-5f);
    }
  }
}

TEST(Remodulate, ThePictureIsFinite) {
  LumaImage3 light = Constant<LumaImage3>(1, 1, 1);
  light[0](2, 0) = light[1](2, 0) = light[2](2, 0) = 3e38f;
  Image3 albedo = Constant(0.5f, 0.5f, 0.5f);
  albedo[1](1, 0) = kNan;  // counts as 1
  for (Image1& plane : albedo.channel) {
    plane(2, 0) = 30;
  }
  Image3 emission = Constant(0, 0, 0);
  emission[0](3, 0) = kNan;
  emission[2](4, 0) = kInfinity;
  emission[1](4, 0) = 5;  // of a pixel with a channel that is not finite, nothing counts
  const SignalLight signal = {&light, {{&albedo}, 1}};
  const std::array<const Image3*, 1> unfiltered = {&emission};
  for (const Version remodulate : kVersions) {
    Image3 picture(9, 2);
    EXPECT_EQ(remodulate({&signal, 1}, unfiltered, {false, false}, &picture), 2);
    EXPECT_NEAR(picture[0](1, 0), 0.5f, 1e-6f);
    EXPECT_NEAR(picture[1](1, 0), 1, 1e-6f);
    EXPECT_EQ(picture[0](2, 0), kMostPicture);
    EXPECT_NEAR(picture[0](3, 0), 0.5f, 1e-6f);
    EXPECT_NEAR(picture[1](4, 0), 0.5f, 1e-6f);
  }
}

TEST(Remodulate, VectorsMatchTheReference) {
  test::ForSizesAndTargets([](int width, int height) {
    const LumaImage3 light[] = {test::RandomImage<LumaImage3>(width, height, 1, 3),
                                test::RandomImage<LumaImage3>(width, height, 4, 3)};
    const Image3 albedo[] = {test::RandomImage(width, height, 7),
                             test::RandomImage(width, height, 10)};
    Image3 emission = test::RandomImage(width, height, 13);
    emission[1](width - 1, height - 1) = kNan;
    const std::vector<SignalLight> signals = {{&light[0], {{&albedo[0], &albedo[1]}, 2}},
                                              {&light[1], {{&albedo[1]}, 1}}};
    const std::array<const Image3*, 1> unfiltered = {&emission};
    for (const bool rec601 : {false, true}) {
      Image3 expected = test::RandomImage(width, height, 16);
      Image3 got = expected;
      EXPECT_EQ(cpu::Remodulate(signals, unfiltered, {rec601, true}, &got),
                reference::Remodulate(signals, unfiltered, {rec601, true}, &expected));
      test::ExpectNear(got, expected, 2e-6, 2e-6);
    }
  });
}

}  // namespace
}  // namespace stillray::remodulate_test
