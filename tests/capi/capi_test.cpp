// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The C API and the C++ API give the same bits, for any memory layout of the images.
#include <thread>

#include "capi/capi_frames.h"
#include "core/colour.h"
#include "stillray/denoise.hpp"

extern "C" const char* StillrayC99Test(void);

namespace stillray::test::capi_test {
namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 29;
constexpr int kFrames = 3;

std::vector<DenoisedFrame> DenoiseInCpp(const std::vector<Frame>& frames, const char* preset,
                                        const std::vector<std::string>& outputs = {}) {
  Denoiser denoiser = std::move(Denoiser::Create(PresetSettings(preset).value()).value());
  EXPECT_TRUE(denoiser.SetOutputs(outputs).ok());
  std::vector<DenoisedFrame> results(frames.size());
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_TRUE(denoiser.Denoise(frames[i], &results[i]).ok());
  }
  return results;
}

std::vector<Frame> BusyFrames(int count = kFrames, uint32_t seed = 7) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(MakeBusyFrame(kWidth, kHeight, i, seed));
  }
  return frames;
}

void ExpectSame(const Image3& expected, const Buffer& got, bool half = false) {
  int different = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < expected.height(); ++y) {
      for (int x = 0; x < expected.width(); ++x) {
        const float value = expected[c](x, y);
        const float wanted = half ? FloatFromHalf(HalfFromFloat(value)) : value;
        const float found = got.Get(x, y, c);
        different += std::memcmp(&wanted, &found, 4) != 0 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(different, 0);
}

TEST(CapiTest, WorksForAC99Program) {
  const char* problem = StillrayC99Test();
  EXPECT_STREQ(problem, nullptr);
}

class CapiLayoutTest : public testing::TestWithParam<std::tuple<const char*, Layout>> {};

TEST_P(CapiLayoutTest, FloatImagesGiveTheBitsOfCpp) {
  const auto [preset, layout] = GetParam();
  const std::vector<Frame> frames = BusyFrames();
  const std::vector<DenoisedFrame> expected = DenoiseInCpp(frames, preset);
  const DenoiserHandle denoiser = MakeDenoiser(preset);
  for (size_t i = 0; i < frames.size(); ++i) {
    CallerFrame caller(frames[i], STILLRAY_FORMAT_FLOAT, layout);
    caller.Run(denoiser.get());
    ExpectSame(expected[i].colour, caller.colour);
  }
}

TEST_P(CapiLayoutTest, HalfImagesGiveTheRoundedBitsOfCpp) {
  const auto [preset, layout] = GetParam();
  std::vector<Frame> frames = BusyFrames();
  for (Frame& frame : frames) {
    frame = RoundedToHalf(std::move(frame));
  }
  const std::vector<DenoisedFrame> expected = DenoiseInCpp(frames, preset);
  const DenoiserHandle denoiser = MakeDenoiser(preset);
  for (size_t i = 0; i < frames.size(); ++i) {
    CallerFrame caller(frames[i], STILLRAY_FORMAT_HALF, layout);
    caller.Run(denoiser.get());
    ExpectSame(expected[i].colour, caller.colour, true);
  }
}

INSTANTIATE_TEST_SUITE_P(Layouts, CapiLayoutTest,
                         testing::Combine(testing::Values("default", "svgf"),
                                          testing::Values(Layout::kInterleaved, Layout::kPlanar,
                                                          Layout::kBottomUp, Layout::kPaddedRgba)));

TEST(CapiTest, OutputMayBeAnInput) {
  const std::vector<Frame> frames = BusyFrames();
  const std::vector<DenoisedFrame> expected = DenoiseInCpp(frames, "default");
  const DenoiserHandle denoiser = MakeDenoiser();
  for (size_t i = 0; i < frames.size(); ++i) {
    CallerFrame caller(frames[i]);
    caller.Give(denoiser.get());
    const Buffer& light = caller.inputs["direct_diffuse"];
    ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "colour", &light.image), STILLRAY_OK);
    ASSERT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_OK);
    ExpectSame(expected[i].colour, light);
  }
}

TEST(CapiTest, LeavesPaddingAndFurtherChannelsAlone) {
  const DenoiserHandle denoiser = MakeDenoiser();
  CallerFrame caller(MakeBusyFrame(kWidth, kHeight, 0), STILLRAY_FORMAT_FLOAT, Layout::kPaddedRgba);
  caller.Run(denoiser.get());
  for (int y = 0; y < kHeight; ++y) {
    const char* row = caller.colour.At(0, y, 0);
    for (int x = 0; x < kWidth; ++x) {
      for (int byte = 12; byte < 16; ++byte) {
        ASSERT_EQ(row[x * 16 + byte], 0x55);
      }
    }
    for (int byte = 0; byte < 13; ++byte) {
      ASSERT_EQ(row[kWidth * 16 + byte], 0x55);
    }
  }
}

TEST(CapiTest, IntermediatePicturesAreThoseOfCpp) {
  const std::vector<Frame> frames = BusyFrames();
  const std::vector<DenoisedFrame> expected =
      DenoiseInCpp(frames, "default", {"variance.direct", "temporal"});
  const DenoiserHandle denoiser = MakeDenoiser();
  for (size_t i = 0; i < frames.size(); ++i) {
    CallerFrame caller(frames[i]);
    caller.Give(denoiser.get());
    const Buffer variance(kWidth, kHeight, 1, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
    const Buffer temporal(kWidth, kHeight, 3, STILLRAY_FORMAT_FLOAT, Layout::kPlanar);
    ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "variance.direct", &variance.image),
              STILLRAY_OK);
    ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "temporal", &temporal.image),
              STILLRAY_OK);
    ASSERT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_OK);
    for (const NamedImage& image : expected[i].images) {
      const Buffer& got = image.name == "temporal" ? temporal : variance;
      for (size_t c = 0; c < image.channels.size(); ++c) {
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            ASSERT_EQ(image.channels[c](x, y), got.Get(x, y, static_cast<int>(c))) << image.name;
          }
        }
      }
    }
  }
}

void ExpectVarianceAndHistoryLength(const char* signals) {
  SCOPED_TRACE(signals);
  const DenoiserHandle denoiser = MakeDenoiser();
  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "signals", signals), STILLRAY_OK);
  // So that the length is the number of frames, even beside noise.
  ASSERT_EQ(stillray_denoiser_set(denoiser.get(), "limit_history", "off"), STILLRAY_OK);
  constexpr int kSide = 64;
  const Buffer variance(kSide, kSide, 1, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  const Buffer length(kSide, kSide, 1, STILLRAY_FORMAT_FLOAT, Layout::kInterleaved);
  double before = 0;
  for (int frame = 0; frame < 8; ++frame) {
    // Direct light is 0 or 2 with equal chance, times the wall's albedo 0.5: variance 0.25. The
    // left half of the picture is without noise.
    Frame wall = MakeWall(kSide, kSide, frame);
    FillImage<3>(&Light(&wall, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
      const float u = Random(static_cast<uint32_t>(frame), static_cast<uint32_t>(x),
                             static_cast<uint32_t>(y) + 1000u);
      return x < kSide / 2 ? 0.5f : u < 0.5f ? 0.0f : 1.0f;
    });
    CallerFrame caller(wall);
    caller.Give(denoiser.get());
    ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "variance", &variance.image),
              STILLRAY_OK);
    ASSERT_EQ(stillray_denoiser_set_output(denoiser.get(), "history_length", &length.image),
              STILLRAY_OK);
    ASSERT_EQ(stillray_denoiser_execute(denoiser.get()), STILLRAY_OK);
    double noisy = 0;
    double clean = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 8; x < kSide / 2 - 8; ++x) {
        EXPECT_EQ(length.Get(x, y, 0), static_cast<float>(frame + 1));
        clean = std::max<double>(clean, variance.Get(x, y, 0));
        noisy += variance.Get(x + kSide / 2, y, 0) / (kSide * (kSide / 2 - 16));
      }
    }
    EXPECT_LT(clean, 1e-6);
    // The variance of the mean of frame + 1 samples, within the uncertainty of so few samples and
    // the deliberate factor for short histories.
    EXPECT_GT(noisy, 0.5 * 0.25 / (frame + 1));
    EXPECT_LT(noisy, (frame < 4 ? 6.0 : 1.5) * 0.25 / (frame + 1));
    if (frame > 0) {
      EXPECT_LT(noisy, before);
    }
    before = noisy;
  }
}

TEST(CapiTest, VarianceAndHistoryLengthForAdaptiveSamplers) {
  ExpectVarianceAndHistoryLength("split");
  ExpectVarianceAndHistoryLength("channels");  // whose deviations add up, not variances
}

TEST(CapiTest, SeveralDenoisersAtOnceOnOneDevice) {
  stillray_device* device = nullptr;
  ASSERT_EQ(stillray_device_create(STILLRAY_ABI_VERSION, 2, &device), STILLRAY_OK);
  constexpr int kThreads = 3;
  std::vector<std::vector<Frame>> frames(kThreads);
  std::vector<std::vector<DenoisedFrame>> expected(kThreads);
  std::vector<std::vector<Buffer>> got(kThreads);
  for (uint32_t t = 0; t < kThreads; ++t) {
    frames[t] = BusyFrames(kFrames, t + 1);
    expected[t] = DenoiseInCpp(frames[t], "default");
  }
  std::vector<std::thread> threads;
  for (size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      stillray_denoiser* made = nullptr;
      ASSERT_EQ(stillray_denoiser_create(device, nullptr, &made), STILLRAY_OK);
      const DenoiserHandle denoiser(made);
      for (const Frame& frame : frames[t]) {
        CallerFrame caller(frame);
        caller.Run(denoiser.get());
        got[t].push_back(std::move(caller.colour));
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  stillray_device_release(device);
  for (size_t t = 0; t < kThreads; ++t) {
    for (size_t i = 0; i < kFrames; ++i) {
      ExpectSame(expected[t][i].colour, got[t][i]);
    }
  }
}

TEST(CapiTest, ThreadCountDoesNotChangeTheBits) {
  const std::vector<Frame> frames = BusyFrames();
  const std::vector<DenoisedFrame> expected = DenoiseInCpp(frames, "default");
  for (const int threads : {1, 3, 16}) {
    const DenoiserHandle denoiser = MakeDenoiser(nullptr, threads);
    for (size_t i = 0; i < frames.size(); ++i) {
      CallerFrame caller(frames[i]);
      caller.Run(denoiser.get());
      ExpectSame(expected[i].colour, caller.colour);
    }
  }
}

TEST(CapiTest, TransmissionIsASignalByName) {
  std::vector<Frame> frames = BusyFrames();
  for (Frame& frame : frames) {
    Signal through;
    through.kind = SignalKind::kIndirectTransmission;
    through.radiance = Light(&frame, SignalKind::kIndirectDiffuse);
    frame.signals.push_back(through);
    frame.guides.transmission_albedo = frame.guides.albedo;
  }
  const std::vector<DenoisedFrame> expected = DenoiseInCpp(frames, "default");
  const DenoiserHandle denoiser = MakeDenoiser();
  for (size_t i = 0; i < frames.size(); ++i) {
    CallerFrame caller(frames[i]);
    caller.Add("transmission_albedo", frames[i].guides.transmission_albedo);
    caller.Run(denoiser.get());
    ExpectSame(expected[i].colour, caller.colour);
  }
}

}  // namespace
}  // namespace stillray::test::capi_test
