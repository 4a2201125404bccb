// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/light_candidates_shared.h"

#include <array>
#include <cmath>

#include "test_scenes.h"

namespace stillray::render::light_candidates_test {
namespace {

constexpr std::array<float, 4> kWeights = {3.0f, 0.5f, 2.0f, 4.5f};  // 10 in all

/// The chosen of kWeights.
struct Chosen {
  size_t number = kWeights.size();
  CandidateChoice choice;
};

Chosen ChooseWith(float u) {
  Chosen chosen{.choice = NoCandidate(u)};
  for (size_t i = 0; i < kWeights.size(); ++i) {
    chosen.number = TakesCandidate(chosen.choice, kWeights[i]) ? i : chosen.number;
  }
  return chosen;
}

TEST(LightCandidatesTest, AreChosenInProportionToTheirWeight) {
  constexpr int kNumbers = 20000;
  std::array<double, 4> part{};
  std::array<double, 4> mean_left{};
  std::array<double, 4> square_left{};
  for (int i = 0; i < kNumbers; ++i) {
    const Chosen chosen = ChooseWith((static_cast<float>(i) + 0.5f) / kNumbers);
    ASSERT_LT(chosen.number, kWeights.size());
    const float left = chosen.choice.u;
    ASSERT_TRUE(left >= 0.0f && left < 1.0f);
    EXPECT_EQ(chosen.choice.weight, kWeights[chosen.number]);
    part[chosen.number] += 1.0 / kNumbers;
    mean_left[chosen.number] += left;
    square_left[chosen.number] += left * left;
  }
  for (size_t i = 0; i < kWeights.size(); ++i) {
    EXPECT_NEAR(part[i], kWeights[i] / 10, 2e-4) << i;
    // What is left of the number is uniform, whatever was chosen.
    const double count = part[i] * kNumbers;
    EXPECT_NEAR(mean_left[i] / count, 1.0 / 2, 2e-3) << i;
    EXPECT_NEAR(square_left[i] / count, 1.0 / 3, 2e-3) << i;
  }
}

// Light that is proportional to the weight has no noise: whichever is chosen counts for the mean.
TEST(LightCandidatesTest, TheChosenOneCountsForTheMeanOfAll) {
  constexpr int kDrawn = 6;  // two of them without light
  for (const float u : {0.0f, 0.2f, 0.34f, 0.5f, 0.99f}) {
    const CandidateChoice choice = ChooseWith(u).choice;
    EXPECT_NEAR(choice.weight * FactorOfChosen(choice, kDrawn), 10.0f / kDrawn, 1e-5f) << u;
  }
}

TEST(LightCandidatesTest, OneCandidateIsThePlainSample) {
  const vec4 u(0.3f, 0.99999994f, 0.0f, 0.7f);
  EXPECT_EQ(CandidateNumbers(u, 0, 1), u);
  CandidateChoice choice = NoCandidate(u.w);
  EXPECT_TRUE(TakesCandidate(choice, 1e-30f));
  EXPECT_EQ(choice.u, u.w);
  EXPECT_EQ(FactorOfChosen(choice, 1), 1.0f);
}

TEST(LightCandidatesTest, SurfacesAfterTheFirstDrawHalfAsMany) {
  LightArrays lights{};
  EXPECT_EQ(CandidateCount(lights, 8, true), 8);
  EXPECT_EQ(CandidateCount(lights, 8, false), 4);
  EXPECT_EQ(CandidateCount(lights, 1, false), 1);
  lights.is_one_point = 1;
  EXPECT_EQ(CandidateCount(lights, 8, true), 1);
}

TEST(LightCandidatesTest, NumbersAreShiftedModuloOne) {
  constexpr int kCount = 8;
  const vec4 u(0.9f, 0.1f, 0.8f, 0.7f);
  std::array<int, kCount> strata{};
  for (int i = 0; i < kCount; ++i) {
    const vec4 shifted = CandidateNumbers(u, i, kCount);
    const double x = 0.9 + i * 0.7548776662;
    const double y = 0.1 + i * 0.5698402910;
    EXPECT_NEAR(shifted.x, x - std::floor(x), 1e-6);
    EXPECT_NEAR(shifted.y, y - std::floor(y), 1e-6);
    EXPECT_EQ(shifted.w, u.w);
    for (int c = 0; c < 3; ++c) {
      EXPECT_TRUE(shifted[c] >= 0.0f && shifted[c] < 1.0f);
    }
    ++strata[static_cast<size_t>(shifted.z * kCount)];
  }
  for (const int count : strata) {
    EXPECT_EQ(count, 1);
  }
}

RenderSettings WithCandidates(int candidates) {
  RenderSettings settings = SmallSettings(16, 12, 1);
  settings.light_candidates = candidates;
  return settings;
}

TEST(LightCandidatesTest, MeanIsTheSameForAnyNumber) {
  const Scene scene = StrategiesScene(0.5f);
  const float one = Luminance709(Mean(RenderMean(scene, WithCandidates(1), 512)));
  ASSERT_GT(one, 0.3f);
  for (const int candidates : {2, 4, 31}) {
    const float mean = Luminance709(Mean(RenderMean(scene, WithCandidates(candidates), 512)));
    EXPECT_NEAR(mean / one, 1.0f, 0.004f) << candidates;
  }
}

// A matte floor lit by a panel close by, whose points differ in distance and cosine, and by
// another.
TEST(LightCandidatesTest, MoreCandidatesHaveLessNoise) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 1, 3));
  builder.Add(Quad(vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8)), Lambert(vec3(0.8f)));
  builder.Add(Quad(vec3(-1, 0.1f, -2), vec3(2, 0, 0), vec3(0, 2, 0)), Emitter(vec3(2.0f)));
  builder.Add(Quad(vec3(2, 2, 1), vec3(0, 0, -1), vec3(-1, 0, 0)), Emitter(vec3(4.0f)));
  const Image3 truth = RenderMean(builder.scene, WithCandidates(16), 1024);
  const auto error = [&](int candidates) {
    return SquaredError(RenderMean(builder.scene, WithCandidates(candidates), 1), truth);
  };
  const double one = error(1);
  const double four = error(4);
  EXPECT_LT(four, 0.5 * one);
  EXPECT_LT(error(16), 0.8 * four);
}

TEST(LightCandidatesTest, OneLightWithoutExtentIsDrawnOnce) {
  const Scene scene = WallWithLamp();
  const Image3 one = RenderMean(scene, WithCandidates(1), 2);
  const Image3 many = RenderMean(scene, WithCandidates(kMaxLightCandidates), 2);
  EXPECT_GT(Mean(one).x, 0.05f);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 16; ++x) {
      ASSERT_EQ(Pixel(many, x, y), Pixel(one, x, y));
    }
  }
}

}  // namespace
}  // namespace stillray::render::light_candidates_test
