// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Outputs that no stage writes by itself: the weight of the new frame, the smoothed variance, the
// sums of the wavelet's weights. stages_test compares them with the scalar version and gpu's
// stages_test with devices; here they meet values worked out by hand.
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "denoise/make_denoiser.h"
#include "denoise/stage_parity.h"
#include "denoise/test_frames.h"

namespace stillray::named_outputs_test {
namespace {

using test::MakeDenoiser;
using test::MakeSparseLight;
using test::MakeWall;
using test::With;

constexpr int kWidth = 24;
constexpr int kHeight = 16;

const Image1& Plane(const DenoisedFrame& out, const std::string& name) {
  static const Image1 none;
  for (const NamedImage& image : out.images) {
    if (image.name == name) {
      return image.channels[0];
    }
  }
  ADD_FAILURE() << "no output " << name;
  return none;
}

TEST(NamedOutputs, AlphaIsTheMeanOverAllSamplesDownToItsLimit) {
  Denoiser denoiser = MakeDenoiser(
      With("svgf", {{"alpha_min", "0.3"}, {"history_weight", "age"}, {"signals", "single"}}));
  ASSERT_TRUE(denoiser.SetOutputs({"alpha"}).ok());
  DenoisedFrame out;
  const float expected[] = {1.0f, 0.5f, 1.0f / 3.0f, 0.3f};
  for (int i = 0; i < 4; ++i) {
    Frame frame = MakeSparseLight(kWidth, kHeight, i, 0.1f);
    frame.samples = Image1(kWidth, kHeight);
    frame.samples.Fill(1.0f);
    frame.samples(5, 6) = i == 3 ? 0.0f : 1.0f;
    ASSERT_TRUE(denoiser.Denoise(frame, &out).ok());
    const Image1& alpha = Plane(out, "alpha.light");
    EXPECT_FLOAT_EQ(alpha(10, 8), expected[i]) << i;
    EXPECT_FLOAT_EQ(alpha(5, 6), i == 3 ? 0.0f : expected[i]) << i;
  }
}

TEST(NamedOutputs, AlphaOfSvgfIsConstantAndRisesWhereTheConfidenceFalls) {
  Denoiser denoiser = MakeDenoiser(PresetSettings("svgf").value());
  ASSERT_TRUE(denoiser.SetOutputs({"alpha.direct"}).ok());
  DenoisedFrame out;
  for (int i = 0; i < 3; ++i) {
    Frame frame = MakeSparseLight(kWidth, kHeight, i, 0.1f);
    frame.confidence = Image1(kWidth, kHeight);
    frame.confidence.Fill(1.0f);
    frame.confidence(3, 4) = 0.5f;
    ASSERT_TRUE(denoiser.Denoise(frame, &out).ok());
  }
  EXPECT_FLOAT_EQ(Plane(out, "alpha.direct")(10, 8), 0.2f);
  // 0.2 against 0.8 / 2.
  EXPECT_FLOAT_EQ(Plane(out, "alpha.direct")(3, 4), 0.2f / 0.6f);
}

TEST(NamedOutputs, SmoothedVarianceIsTheBinomialMeanOfItsNeighbours) {
  Denoiser denoiser = MakeDenoiser(PresetSettings("default").value());
  ASSERT_TRUE(denoiser.SetOutputs({"variance", "smoothed_variance"}).ok());
  DenoisedFrame out;
  for (int i = 0; i < 3; ++i) {
    Frame frame = MakeSparseLight(kWidth, kHeight, i, 0.1f);
    frame.guides.depth(0, 0) = std::numeric_limits<float>::infinity();
    ASSERT_TRUE(denoiser.Denoise(frame, &out).ok());
  }
  const Image1& variance = Plane(out, "variance.direct");
  const Image1& smoothed = Plane(out, "smoothed_variance.direct");
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double sum = 0;
      double weights = 0;
      for (int i = 0; i < 9; ++i) {
        const int qx = x + i % 3 - 1;
        const int qy = y + i / 3 - 1;
        if (qx < 0 || qy < 0 || qx >= kWidth || qy >= kHeight || (qx == 0 && qy == 0)) {
          continue;
        }
        constexpr double kRow[] = {1, 2, 1};
        const double w = kRow[i % 3] * kRow[i / 3];
        sum += w * static_cast<double>(variance(qx, qy));
        weights += w;
      }
      const double expected = x == 0 && y == 0 ? 0 : sum / weights;
      ASSERT_NEAR(smoothed(x, y), expected, 1e-5 * expected + 1e-12) << x << " " << y;
    }
  }
}

// Under even light all taps count with the kernel's weights, whose sum is 1; taps outside the
// picture and on another surface are missing.
TEST(NamedOutputs, SumsOfWeightsAreThoseOfTheKernelInThePicture) {
  Denoiser denoiser = MakeDenoiser(With(
      "svgf", {{"kernel", "3x3"}, {"steps", "1,2"}, {"wavelet_id", "on"}, {"signals", "single"}}));
  ASSERT_TRUE(denoiser.SetOutputs({"weights1", "weights2"}).ok());
  Frame frame = MakeWall(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    test::Light(&frame, SignalKind::kDirectDiffuse)[c].Fill(1.0f);
  }
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 12; x < kWidth; ++x) {
      frame.guides.id(x, y) = 2;
    }
  }
  frame.guides.depth(20, 8) = std::numeric_limits<float>::infinity();
  DenoisedFrame out;
  ASSERT_TRUE(denoiser.Denoise(frame, &out).ok());
  const Image1& first = Plane(out, "weights1.light");
  const Image1& second = Plane(out, "weights2.light");
  EXPECT_NEAR(first(6, 8), 1, 1e-5);
  EXPECT_NEAR(first(0, 8), 0.75, 1e-5);    // a column of the kernel is outside
  EXPECT_NEAR(first(0, 0), 0.5625, 1e-5);  // and a row
  EXPECT_NEAR(first(11, 8), 0.75, 1e-5);   // a column is on the other surface
  EXPECT_NEAR(first(10, 8), 1, 1e-5);
  EXPECT_NEAR(second(10, 8), 0.75, 1e-5);  // two pixels further at the second level
  EXPECT_NEAR(second(1, 8), 0.75, 1e-5);
  EXPECT_NEAR(first(19, 8), 1 - 0.125, 1e-5);  // beside the hole
  EXPECT_EQ(first(20, 8), 0);
}

TEST(NamedOutputs, NamesAreThoseOfTheSettings) {
  const Settings settings = With("svgf", {{"steps", "1,2"}, {"signals", "single"}});
  const std::vector<std::string> names = Denoiser::OutputNames(settings);
  const auto count = [&](const std::string& name) {
    return std::count(names.begin(), names.end(), name);
  };
  for (const char* name :
       {"alpha.light", "smoothed_variance.light", "weights1.light", "weights2.light", "atrous2"}) {
    EXPECT_EQ(count(name), 1) << name;
  }
  EXPECT_EQ(count("weights3.light"), 0);
}

}  // namespace
}  // namespace stillray::named_outputs_test
