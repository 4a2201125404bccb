// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/one_signal.h"

#include <gtest/gtest.h>

#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::one_signal_test {
namespace {

/// Frames of four signals without invalid light: with it, one signal of the sum would differ from
/// the signals of the parts.
Frame WithoutBrokenLight(int64_t index) {
  Frame frame = test::MakeBusyFrame(37, 23, index);
  for (Signal& signal : frame.signals) {
    test::FillImage(&signal.radiance, [&](int x, int y, int c) {
      return test::Random(static_cast<uint32_t>(x * 7 + c), static_cast<uint32_t>(y),
                          static_cast<uint32_t>(index * 4) + static_cast<uint32_t>(signal.kind));
    });
  }
  return frame;
}

TEST(OneSignalTest, IsFilteredToTheSamePicture) {
  Settings settings = *PresetSettings("svgf");
  settings.signals = SignalGrouping::kSingle;
  Result<Denoiser> of_all = Denoiser::Create(settings);
  Result<Denoiser> of_one = Denoiser::Create(settings);
  ASSERT_TRUE(of_all.ok() && of_one.ok());
  Frame one;
  DenoisedFrame expected;
  DenoisedFrame actual;
  for (int64_t index = 0; index < 4; ++index) {
    const Frame frame = WithoutBrokenLight(index);
    ToOneSignal(frame, &one);
    ASSERT_EQ(one.signals.size(), 1u);
    ASSERT_TRUE(of_all->Denoise(frame, &expected).ok());
    ASSERT_TRUE(of_one->Denoise(one, &actual).ok());
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
          const float value = expected.colour[c](x, y);
          ASSERT_NEAR(actual.colour[c](x, y), value, 1e-4f * (1 + value))
              << "frame " << index << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST(OneSignalTest, FramesWithSecondMomentsStayAsTheyAre) {
  Frame frame = test::MakeWall(4, 3);
  frame.signals[1].second_moment = Image1(4, 3);
  Frame one;
  ToOneSignal(frame, &one);
  EXPECT_EQ(one.signals.size(), 4u);
}

}  // namespace
}  // namespace stillray::one_signal_test
