// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/merge_future.h"

#include <gtest/gtest.h>

#include "stage_test.h"

namespace stillray::merge_future_test {
namespace {

using Version = decltype(&cpu::MergeFuture);
constexpr Version kVersions[] = {&reference::MergeFuture, &cpu::MergeFuture};

/// \param value  of the light and its mean
SignalHistory Constant(float value, float variance, float length, float weights2) {
  SignalHistory history(9, 2);
  for (Image1& plane : history.colour.channel) {
    plane.Fill(value);
  }
  history.mean.Fill(value);
  history.variance.Fill(variance);
  history.length.Fill(length);
  history.weights2.Fill(weights2);
  return history;
}

TEST(MergeFuture, WeightsAreInverseNoise) {
  // Means of 4 and of 12 samples: the future has 3/4 of the 16.
  const SignalHistory past = Constant(1, 2, 4, 1.0f / 4);
  const SignalHistory future = Constant(4, 0.5f, 12, 1.0f / 12);
  for (const Version merge : kVersions) {
    SignalHistory out(9, 2);
    merge(past, future, &out);
    EXPECT_FLOAT_EQ(out.colour[2](8, 1), 3.25f);
    EXPECT_FLOAT_EQ(out.mean(8, 1), 3.25f);
    EXPECT_FLOAT_EQ(out.length(8, 1), 16);
    EXPECT_FLOAT_EQ(out.weights2(8, 1), 1.0f / 16);
    // Within both sets, and between their means: 1/4 * 2 + 3/4 * 0.5 + 1/4 * 3/4 * 3^2.
    EXPECT_FLOAT_EQ(out.variance(8, 1), 2.5625f);
  }
}

TEST(MergeFuture, OneSideAloneIsUnchanged) {
  const SignalHistory light = Constant(3, 0.7f, 5, 0.2f);
  const SignalHistory none = Constant(0, 0, 0, 0);
  for (const Version merge : kVersions) {
    for (const bool of_past : {true, false}) {
      SignalHistory out(9, 2);
      merge(of_past ? light : none, of_past ? none : light, &out);
      test::ExpectEqual(out.colour[1], light.colour[1]);
      test::ExpectEqual(out.mean, light.mean);
      test::ExpectEqual(out.variance, light.variance);
      test::ExpectEqual(out.length, light.length);
      test::ExpectEqual(out.weights2, light.weights2);
    }
  }
}

SignalHistory RandomHistory(int width, int height, uint32_t seed) {
  SignalHistory h(width, height);
  h.colour = test::RandomImage<LumaImage3>(width, height, seed, 5);
  h.length = test::MakePlane(
      width, height, [&](int x, int y) { return std::floor(4 * test::RandomAt(x, y, seed + 3)); },
      SignalHistory::kBorder);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float length = h.length(x, y);
      h.mean(x, y) = length > 0 ? h.colour[0](x, y) : 0.0f;
      h.variance(x, y) = length > 0 ? test::RandomAt(x, y, seed + 4) : 0.0f;
      h.weights2(x, y) = length > 0 ? 1 / length : 0.0f;
    }
  }
  return h;
}

void ExpectNear(const SignalHistory& got, const SignalHistory& expected) {
  test::ExpectNear(got.colour, expected.colour, 1e-6, 1e-6);
  test::ExpectNear(got.mean, expected.mean, 1e-6, 1e-6);
  test::ExpectNear(got.variance, expected.variance, 1e-6, 1e-6);
  test::ExpectNear(got.length, expected.length, 0);
  test::ExpectNear(got.weights2, expected.weights2, 1e-6);
}

TEST(MergeFuture, VectorsMatchTheReferenceAlsoInPlace) {
  test::ForSizesAndTargets([](int width, int height) {
    const SignalHistory past = RandomHistory(width, height, 20);
    const SignalHistory future = RandomHistory(width, height, 30);
    SignalHistory expected(width, height);
    reference::MergeFuture(past, future, &expected);
    SignalHistory got(width, height);
    cpu::MergeFuture(past, future, &got);
    ExpectNear(got, expected);
    SignalHistory in_place = past;
    cpu::MergeFuture(in_place, future, &in_place);
    ExpectNear(in_place, expected);
  });
}

}  // namespace
}  // namespace stillray::merge_future_test
