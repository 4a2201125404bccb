// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// signals=channels: red, green and blue are signals of their own.
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "denoise/make_denoiser.h"
#include "denoise/signal_groups.h"
#include "denoise/stage_parity.h"
#include "denoise/stages/demodulate.h"
#include "denoise/stages/demodulate_shared.h"
#include "denoise/test_frames.h"

namespace stillray::test::channels_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 45;
constexpr int kHeight = 31;
constexpr int kFrames = 5;

/// A busy frame whose channels differ, without broken samples, which all channels would share.
Frame Colourful(int index, bool with_moments) {
  Frame f = MakeBusyFrame(kWidth, kHeight, index);
  uint32_t salt = 300;
  for (Signal& signal : f.signals) {
    ++salt;
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          float& light = signal.radiance[c](x, y);
          light = std::isfinite(light) && light > 0 ? light : 0.0f;
          light *= Random(salt, static_cast<uint32_t>(y * kWidth + x), static_cast<uint32_t>(c));
        }
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    f.guides.albedo[c].Fill(0.3f + 0.2f * static_cast<float>(c));
  }
  if (with_moments) {
    f.samples.Fill(4);
    for (Signal& signal : f.signals) {  // below the squared mean: no noise
      signal.second_moment = Image1(kWidth, kHeight);
    }
    Signal& direct = f.signals.front();
    FillImage(&direct.second_moment, [&](int x, int y) {
      float mean = 0;
      for (const auto& [c, weight] : {std::pair{0, 0.2126f}, {1, 0.7152f}, {2, 0.0722f}}) {
        mean += weight * direct.radiance[c](x, y) / f.guides.albedo[c](x, y);
      }
      return 3 * mean * mean;
    });
  }
  return f;
}

/// The frame with one channel in place of all three.
Frame Grey(const Frame& frame, int channel) {
  Frame grey = frame;
  const auto use = [&](Image3* image) {
    for (int c = 0; c < 3 && !image->empty(); ++c) {
      for (int y = 0; y < kHeight; ++y) {
        std::copy_n(Image1((*image)[channel]).Row(y), kWidth, (*image)[c].Row(y));
      }
    }
  };
  for (Signal& signal : grey.signals) {
    use(&signal.radiance);
    if (&signal == &grey.signals.front() &&
        !signal.second_moment.empty()) {  // hue is constant: channels vary in proportion
      FillImage(&signal.second_moment, [&](int x, int y) {
        const float mean = signal.radiance[0](x, y) / frame.guides.albedo[channel](x, y);
        return 3 * mean * mean;
      });
    }
  }
  use(&grey.guides.albedo);
  use(&grey.guides.specular_albedo);
  use(&grey.emission);
  use(&grey.background);
  return grey;
}

void ExpectThreeGreyPictures(Settings settings, bool with_moments, const std::string& what) {
  settings.antialias = Antialias::kOff;  // it compares luminances of the picture, as fxaa does
  settings.fxaa = Fxaa::kOff;
  settings.signals = SignalGrouping::kChannels;
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser coloured = MakeDenoiser(settings, backend);
    Settings of_grey = settings;
    of_grey.signals = SignalGrouping::kSingle;
    std::vector<Denoiser> grey;
    for (int c = 0; c < 3; ++c) {
      grey.push_back(MakeDenoiser(of_grey, backend));
    }
    for (int i = 0; i < kFrames; ++i) {
      const Frame frame = Colourful(i, with_moments);
      DenoisedFrame picture;
      ASSERT_TRUE(coloured.Denoise(frame, &picture).ok());
      for (int c = 0; c < 3; ++c) {
        DenoisedFrame expected;
        ASSERT_TRUE(grey[static_cast<size_t>(c)].Denoise(Grey(frame, c), &expected).ok());
        // Where a threshold decides, a rounding changes a pixel.
        const Difference d = Compare(picture.colour[c], expected.colour[c], 1e-5);
        EXPECT_LT(d.rms, 2e-5) << what << " channel " << c << " frame " << i;
        EXPECT_LT(d.outliers, 0.002) << what << " channel " << c << " frame " << i;
      }
    }
  }
}

TEST(Channels, AreThreeGreyPictures) {
  for (const char* preset : {"default", "best", "svgf", "psvgf", "eaw", "temporal"}) {
    ExpectThreeGreyPictures(PresetSettings(preset).value(), false, preset);
  }
  ExpectThreeGreyPictures(With("psvgf", {{"firefly", "compress"}, {"demodulate", "off"}}), false,
                          "compressed, not divided");
  ExpectThreeGreyPictures(With("default", {{"firefly", "clamp"}}), true, "with moments");
}

TEST(Channels, AreGreySignalsOfTheLight) {
  Image3 light(9, 2);
  Image3 albedo(9, 2);
  Image1 moment(9, 2);
  const float lights[3] = {1, 2, 4};
  const float albedos[3] = {0.5f, 0.25f, 1};
  for (int c = 0; c < 3; ++c) {
    light[c].Fill(lights[c]);
    albedo[c].Fill(albedos[c]);
  }
  const double luminance = 0.2126 * 2 + 0.7152 * 8 + 0.0722 * 4;
  moment.Fill(static_cast<float>(3 * luminance * luminance));  // variance: twice its square
  for (int c = 0; c < 3; ++c) {
    DemodulateInput in;
    in.radiance[0] = &light;
    in.second_moment[0] = &moment;
    in.own_albedo[0] = &albedo;
    in.count = 1;
    in.albedo = {{&albedo}, 1, c};
    for (const auto demodulate : {&reference::Demodulate, &cpu::Demodulate}) {
      NewLight out = {LumaImage3(9, 2), Image1(9, 2), Image1(9, 2)};
      demodulate(in, &out);
      const float expected = lights[c] / albedos[c];
      for (int k = 0; k < 3; ++k) {
        EXPECT_FLOAT_EQ(out.colour[k](8, 1), expected);
      }
      EXPECT_NEAR(out.within(8, 1), 2 * expected * expected, 1e-3f);
    }
  }
  EXPECT_EQ(ChannelDeviation(1, 0, 1, 1), 0.0f);
}

TEST(Channels, CountInvalidPixelsOnce) {
  const auto counts = [](SignalGrouping signals) {
    Settings settings;
    settings.signals = signals;
    Denoiser d = MakeDenoiser(settings);
    DenoisedFrame out;
    EXPECT_TRUE(d.Denoise(MakeBusyFrame(kWidth, kHeight, 0), &out).ok());
    return std::pair{out.non_finite, out.negative};
  };
  EXPECT_EQ(counts(SignalGrouping::kChannels), counts(SignalGrouping::kSingle));
}

TEST(Channels, KeepTheMeanOfEachChannel) {
  constexpr int kFirst = 16;  // of the frames whose pictures are averaged
  constexpr int kFrames = 40;
  Settings settings = With("default", {{"signals", "channels"}, {"antialias", "off"}});
  Denoiser d = MakeDenoiser(settings);
  DenoisedFrame out;
  double sum[3] = {};
  for (int i = 0; i < kFrames; ++i) {
    Frame f = MakeWall(96, 64, i);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int c) {
      const auto draw = static_cast<uint32_t>(3 * i + c);
      const float u = Random(draw, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
      return u < 0.25f ? 2.0f * static_cast<float>(c + 1) : 0.0f;
    });
    ASSERT_TRUE(d.Denoise(f, &out).ok());
    for (int c = 0; i >= kFirst && c < 3; ++c) {
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 96; ++x) {
          sum[c] += static_cast<double>(out.colour[c](x, y)) / (kFrames - kFirst);
        }
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(sum[c] / (96 * 64), 0.5 * (c + 1), 0.006 * (c + 1)) << c;
  }
}

TEST(Channels, AHistoryOfOtherSignalsIsRefused) {
  Settings settings;
  settings.signals = SignalGrouping::kChannels;
  Denoiser channels = MakeDenoiser(settings);
  Denoiser split = MakeDenoiser(Settings());  // three signals too
  DenoisedFrame out;
  ASSERT_TRUE(channels.Denoise(MakeBusyFrame(kWidth, kHeight, 0), &out).ok());
  const std::vector<uint8_t> saved = channels.SaveHistory().value();
  EXPECT_THAT(split.RestoreHistory(saved).message(),
              HasSubstr("signals of channels, the settings ask for those of kinds of light"));
  Denoiser again = MakeDenoiser(settings);
  ASSERT_TRUE(again.RestoreHistory(saved).ok());
  const Frame next = MakeBusyFrame(kWidth, kHeight, 1);
  DenoisedFrame expected;
  ASSERT_TRUE(channels.Denoise(next, &expected).ok());
  ASSERT_TRUE(again.Denoise(next, &out).ok());
  EXPECT_TRUE(SameBits(out.colour, expected.colour));
}

TEST(Channels, HaveNames) {
  Settings settings;
  settings.signals = SignalGrouping::kChannels;
  const std::vector<std::string> names = Denoiser::OutputNames(settings);
  for (const char* name : {"variance.red", "history.green", "noisy.blue"}) {
    EXPECT_THAT(names, ::testing::Contains(name));
  }
}

}  // namespace
}  // namespace stillray::test::channels_test
