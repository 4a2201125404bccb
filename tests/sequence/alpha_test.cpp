// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/alpha.h"

#include <cmath>
#include <limits>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/cli_denoise_shot.h"

namespace stillray::alpha_test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

/// A wall that faces the camera, with nothing beside it from column `end` on.
Frame Wall(int64_t index, int end = kWidth) {
  Frame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  frame.index = index;
  frame.guides.depth = Image1(kWidth, kHeight);
  frame.guides.normal = Image3(kWidth, kHeight);
  frame.guides.motion = Image2(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      frame.guides.depth(x, y) = x < end ? 4 : std::numeric_limits<float>::infinity();
      frame.guides.normal[2](x, y) = x < end ? 1.0f : 0.0f;
    }
  }
  return frame;
}

/// One sample per pixel of a surface that covers this part of it.
Image1 Covered(float part, int64_t frame) {
  Image1 alpha(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      alpha(x, y) = ShotNoise(x, y, frame) < part ? 1.0f : 0.0f;
    }
  }
  return alpha;
}

Settings Default() {
  return PresetSettings("default").value();
}

TEST(AlphaFilter, OpaqueFramesTakeNothing) {
  AlphaFilter filter(Default(), Device());
  Image1 alpha(kWidth, kHeight);
  alpha.Fill(1);
  ASSERT_TRUE(filter.Filter(Wall(1), FutureLight(), &alpha).ok());
  EXPECT_EQ(alpha(3, 3), 1);
  EXPECT_EQ(filter.memory_bytes(), 0u);
  EXPECT_THAT(filter.SaveHistory().value(), ::testing::IsEmpty());
}

TEST(AlphaFilter, NoiseLeavesAndTheMeanStays) {
  for (const float part : {0.1f, 0.5f, 0.9f}) {
    AlphaFilter filter(Default(), Device());
    Image1 alpha;
    for (int64_t frame = 1; frame <= 10; ++frame) {
      alpha = Covered(part, frame);
      ASSERT_TRUE(filter.Filter(Wall(frame), FutureLight(), &alpha).ok());
    }
    double sum = 0;
    double squares = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        EXPECT_GE(alpha(x, y), 0);
        EXPECT_LE(alpha(x, y), 1);
        sum += alpha(x, y);
        squares += std::pow(alpha(x, y) - part, 2);
      }
    }
    const double noise = part * (1 - part);
    EXPECT_NEAR(sum / (kWidth * kHeight), part, 0.015) << part;
    EXPECT_LT(squares / (kWidth * kHeight), 0.02 * noise) << part;
  }
}

TEST(AlphaFilter, AlphaOfLaterFramesCounts) {
  Result<Denoiser> backward = Denoiser::Create(SettingsOfAlpha(Default()));
  ASSERT_TRUE(backward.ok());
  FutureLight future;
  for (int64_t frame = 8; frame >= 1; --frame) {
    ASSERT_TRUE(
        backward->Accumulate(FrameOfAlpha(Wall(frame), Covered(0.5f, frame)), &future).ok());
  }
  const auto squared_error = [](const FutureLight& later) {
    AlphaFilter filter(Default(), Device());
    Image1 alpha = Covered(0.5f, 1);
    EXPECT_TRUE(filter.Filter(Wall(1), later, &alpha).ok());
    double sum = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        sum += std::pow(alpha(x, y) - 0.5, 2);
      }
    }
    return sum;
  };
  EXPECT_LT(squared_error(future), 0.6 * squared_error(FutureLight()));
}

/// What changes without motion, as smoke does.
TEST(AlphaFilter, AHistoryWithoutConfidenceIsForgotten) {
  Settings settings = Default();
  settings.limit_history = false;  // would find this change by itself
  const auto mean_after = [&](float confidence) {
    AlphaFilter filter(settings, Device());
    Image1 alpha;
    for (int64_t frame = 1; frame <= 6; ++frame) {
      alpha = Covered(frame < 6 ? 0.9f : 0.2f, frame);
      Frame wall = Wall(frame);
      wall.confidence = Image1(kWidth, kHeight);
      wall.confidence.Fill(confidence);
      EXPECT_TRUE(filter.Filter(wall, FutureLight(), &alpha).ok());
    }
    double sum = 0;
    for (int y = 0; y < kHeight; ++y) {
      sum += std::accumulate(alpha.Row(y), alpha.Row(y) + kWidth, 0.0);
    }
    return sum / (kWidth * kHeight);
  };
  EXPECT_NEAR(mean_after(0), 0.2, 0.015);
  EXPECT_GT(mean_after(1), 0.5);
}

TEST(AlphaFilter, EdgesWithoutNoiseStay) {
  AlphaFilter filter(Default(), Device());
  for (int64_t frame = 1; frame <= 6; ++frame) {
    Image1 alpha(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < 40; ++x) {
        alpha(x, y) = x < 20 ? 1.0f : 0.25f;  // a second sheet on the same wall
      }
    }
    const Image1 given = alpha;
    ASSERT_TRUE(filter.Filter(Wall(frame, 40), FutureLight(), &alpha).ok());
    // The variance of a first frame is that of its pixels' neighbourhoods, edges included.
    for (int y = 0; y < kHeight && frame == 6; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        EXPECT_NEAR(alpha(x, y), given(x, y), 0.01) << x << " " << y;
      }
    }
  }
}

TEST(AlphaFilter, ASavedHistoryGoesOnWithTheSameBits) {
  AlphaFilter whole(Default(), Device());
  for (int64_t frame = 1; frame <= 3; ++frame) {
    Image1 alpha = Covered(0.5f, frame);
    ASSERT_TRUE(whole.Filter(Wall(frame), FutureLight(), &alpha).ok());
  }
  const Result<std::vector<uint8_t>> saved = whole.SaveHistory();
  ASSERT_TRUE(saved.ok());
  AlphaFilter restored(Default(), Device());
  ASSERT_TRUE(restored.RestoreHistory(*saved).ok());
  Image1 a = Covered(0.5f, 4);
  Image1 b = a;
  ASSERT_TRUE(whole.Filter(Wall(4), FutureLight(), &a).ok());
  ASSERT_TRUE(restored.Filter(Wall(4), FutureLight(), &b).ok());
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(a(x, y), b(x, y));
    }
  }
  EXPECT_FALSE(restored.RestoreHistory(std::span(*saved).first(saved->size() / 2)).ok());
}

}  // namespace
}  // namespace stillray::alpha_test
