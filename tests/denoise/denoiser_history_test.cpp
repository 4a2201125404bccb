// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The history: reprojection, saving, and resets.
#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/checksum.h"
#include "denoise/make_denoiser.h"
#include "denoise/test_frames.h"
#include "stillray/denoise.hpp"

namespace stillray::denoiser_history_test {
namespace {

using test::FillImage;
using test::Light;
using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::MakeWall;
using test::SameBits;
using ::testing::HasSubstr;

TEST(Denoiser, SavedHistoryContinuesWithTheSameBits) {
  for (const auto& [preset, normals] : {std::pair{"default", NormalStorage::kAuto},
                                        {"best", NormalStorage::kAuto},
                                        {"svgf", NormalStorage::kAuto},
                                        {"default", NormalStorage::kOctahedral}}) {
    Settings s = PresetSettings(preset).value();
    s.normals = normals;
    Denoiser whole = MakeDenoiser(s);
    DenoisedFrame expected;
    std::vector<uint8_t> saved;
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(whole.Denoise(MakeBusyFrame(40, 30, i), &expected).ok());
      if (i == 2) {
        saved = whole.SaveHistory().value();
      }
    }
    Denoiser resumed = MakeDenoiser(s);
    ASSERT_TRUE(resumed.RestoreHistory(saved).ok());
    DenoisedFrame out;
    for (int i = 3; i < 6; ++i) {
      ASSERT_TRUE(resumed.Denoise(MakeBusyFrame(40, 30, i), &out).ok());
    }
    EXPECT_TRUE(SameBits(out.colour, expected.colour)) << preset;
    EXPECT_EQ(resumed.SaveHistory().value(), whole.SaveHistory().value());
  }
}

TEST(Denoiser, DamagedHistoryIsRefused) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(16, 16, 0), &out).ok());
  std::vector<uint8_t> saved = d.SaveHistory().value();
  EXPECT_TRUE(d.RestoreHistory(saved).ok());
  EXPECT_EQ(d.RestoreHistory(std::span(saved).first(10)).code(), StatusCode::kBadData);
  EXPECT_EQ(d.RestoreHistory(std::span(saved).first(saved.size() - 1)).code(),
            StatusCode::kBadData);
  Denoiser other = MakeDenoiser(PresetSettings("svgf").value());
  EXPECT_THAT(other.RestoreHistory(saved).message(),
              HasSubstr("made with limit_history on, the settings have it off"));
  Settings single;
  single.signals = SignalGrouping::kSingle;
  EXPECT_THAT(MakeDenoiser(single).RestoreHistory(saved).message(),
              HasSubstr("3 signals, the settings ask for 1"));
  Settings octahedral;
  octahedral.normals = NormalStorage::kOctahedral;
  EXPECT_THAT(MakeDenoiser(octahedral).RestoreHistory(saved).message(),
              HasSubstr("has plain normals, this denoiser keeps octahedral ones"));
  Settings plain;
  plain.normals = NormalStorage::kPlain;
  EXPECT_TRUE(MakeDenoiser(plain).RestoreHistory(saved).ok());
  saved[0] = 'x';
  EXPECT_EQ(d.RestoreHistory(saved).code(), StatusCode::kBadData);
}

// Damage anywhere is found: a wrong value in the history would stay for many frames.
TEST(Denoiser, HistoryWithAnyByteChangedIsRefused) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(16, 16, 0), &out).ok());
  const std::vector<uint8_t> saved = d.SaveHistory().value();
  for (size_t at = 0; at < saved.size(); at += at < 64 ? 1 : 97) {
    std::vector<uint8_t> damaged = saved;
    damaged[at] ^= 0x10;
    ASSERT_EQ(d.RestoreHistory(damaged).code(), StatusCode::kBadData) << "byte " << at;
  }
  EXPECT_EQ(d.SaveHistory().value(), saved) << "history changed by a failure";
}

TEST(Denoiser, HistoryWithNanIsRefused) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value());
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(16, 16, 0), &out).ok());
  std::vector<uint8_t> saved = d.SaveHistory().value();
  constexpr size_t kChecksumAt = 48;
  constexpr size_t kHeaderBytes = 56;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(saved.data() + kHeaderBytes + 400, &nan, sizeof(nan));
  std::memset(saved.data() + kChecksumAt, 0, sizeof(uint64_t));
  const uint64_t sum = AddToChecksum(saved);
  std::memcpy(saved.data() + kChecksumAt, &sum, sizeof(sum));
  const Status status = d.RestoreHistory(saved);
  EXPECT_EQ(status.code(), StatusCode::kBadData);
  EXPECT_THAT(status.message(), HasSubstr("no numbers"));
}

TEST(Denoiser, HistoryLengthOfAStillView) {
  Settings s = PresetSettings("default").value();
  s.limit_history = false;
  Denoiser d = MakeDenoiser(s);
  ASSERT_TRUE(d.SetOutputs({"history"}).ok());
  DenoisedFrame out;
  for (int i = 1; i <= 20; ++i) {
    ASSERT_TRUE(d.Denoise(MakeWall(20, 20, i), &out).ok());
    ASSERT_EQ(out.images.size(), 3u);
    EXPECT_EQ(out.images[0].name, "history.direct");
    EXPECT_EQ(out.images[0].channels[0](7, 7), static_cast<float>(i));
  }
  d.Reset();
  ASSERT_TRUE(d.Denoise(MakeWall(20, 20, 21), &out).ok());
  EXPECT_EQ(out.images[0].channels[0](7, 7), 1.0f);
}

TEST(Denoiser, DisocclusionMaskOfAMovingQuadIsExact) {
  // A quad of 12x10 pixels moves right by 3 pixels per frame in front of a wall: it uncovers a
  // strip of exactly 3x10 pixels at its left.
  Settings s = PresetSettings("default").value();
  s.history_search = false;
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = MakeDenoiser(s, backend);
    ASSERT_TRUE(d.SetOutputs({"disocclusion"}).ok());
    DenoisedFrame out;
    for (int i = 0; i < 5; ++i) {
      Frame f = MakeWall(64, 32, i);
      const int left = 10 + 3 * i;
      for (int y = 8; y < 18; ++y) {
        for (int x = left; x < left + 12; ++x) {
          f.guides.depth(x, y) = 3;
          f.guides.id(x, y) = 2;
          f.guides.motion[0](x, y) = -3;
        }
      }
      ASSERT_TRUE(d.Denoise(f, &out).ok());
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 64; ++x) {
          const bool uncovered = i > 0 && y >= 8 && y < 18 && x >= left - 3 && x < left;
          EXPECT_EQ(out.images[0].channels[0](x, y), uncovered || i == 0 ? 1.0f : 0.0f)
              << i << ": " << x << " " << y;
        }
      }
    }
  }
}

TEST(Denoiser, ReprojectionIsExactToAHundredthOfAPixel) {
  // A picture painted on a wall, seen sharp in the first frame; in the second no light arrives, so
  // that the history alone shows. A straight ramp turns places into values without error.
  constexpr float kMotionX = 1.37f;
  constexpr float kMotionY = -2.61f;
  const auto paint = [](double x, double y) { return 1 + 0.05 * x + 0.03 * y; };
  Denoiser d = MakeDenoiser(PresetSettings("temporal").value());
  ASSERT_TRUE(d.SetOutputs({"accumulated"}).ok());
  DenoisedFrame out;
  for (int i = 0; i < 2; ++i) {
    Frame f = MakeWall(48, 32, i);
    f.guides.motion[0].Fill(kMotionX);
    f.guides.motion[1].Fill(kMotionY);
    FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse),
                 [&](int x, int y, int) { return static_cast<float>(paint(x, y)); });
    f.samples = Image1(48, 32);
    f.samples.Fill(i == 0 ? 1.0f : 0.0f);
    ASSERT_TRUE(d.Denoise(f, &out).ok());
  }
  for (const NamedImage& image : out.images) {
    if (image.name != "accumulated.direct") {
      continue;
    }
    for (int y = 4; y < 30; ++y) {
      for (int x = 2; x < 44; ++x) {
        const double albedo = 0.5;  // of the wall
        EXPECT_NEAR(image.channels[0](x, y) * albedo,
                    paint(x + static_cast<double>(kMotionX), y + static_cast<double>(kMotionY)),
                    0.01 * 0.03);
      }
    }
    return;
  }
  FAIL() << "no such output";
}

TEST(Denoiser, AChangeOfSizeStartsAnew) {
  Denoiser d = MakeDenoiser(Settings());
  Denoiser fresh = MakeDenoiser(Settings());
  DenoisedFrame a;
  DenoisedFrame b;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(30, 20, 0), &a).ok());
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(21, 40, 1), &a).ok());
  ASSERT_TRUE(fresh.Denoise(MakeBusyFrame(21, 40, 1), &b).ok());
  EXPECT_TRUE(SameBits(a.colour, b.colour));
}

TEST(Denoiser, BlackHistoryEndsWhenLightComes) {
  for (const Backend backend : {Backend::kReference, Backend::kCpu}) {
    Denoiser d = MakeDenoiser(PresetSettings("default").value(), backend);
    ASSERT_TRUE(d.SetOutputs({"limit.direct"}).ok());
    Frame frame = MakeWall(40, 30);
    DenoisedFrame out;
    for (int i = 0; i < 8; ++i) {
      ASSERT_TRUE(d.Denoise(frame, &out).ok());
    }
    Light(&frame, SignalKind::kDirectDiffuse)[1].Fill(1);
    ASSERT_TRUE(d.Denoise(frame, &out).ok());
    EXPECT_LT(out.images[0].channels[0](20, 15), 0.1f);
    EXPECT_GT(out.colour[1](20, 15), 0.9f);
  }
}

TEST(Denoiser, AChangeOfLightEndsHistory) {
  // The light doubles at once. With limit_history the picture follows within a few frames, without
  // it lags.
  const auto after = [](bool limit) {
    Settings s;
    s.limit_history = limit;
    s.antialias = Antialias::kOff;
    Denoiser d = MakeDenoiser(s);
    DenoisedFrame out;
    for (int i = 0; i < 33; ++i) {
      Frame f = MakeWall(64, 48, i);
      const float level = i < 30 ? 1.0f : 3.0f;
      FillImage<3>(&Light(&f, SignalKind::kDirectDiffuse), [&](int x, int y, int) {
        return level * (0.5f + test::Random(static_cast<uint32_t>(i), static_cast<uint32_t>(x),
                                            static_cast<uint32_t>(y)));
      });
      EXPECT_TRUE(d.Denoise(f, &out).ok());
    }
    double sum = 0;
    for (int x = 0; x < 64; ++x) {
      sum += out.colour[0](x, 24) / 64;
    }
    return sum;
  };
  EXPECT_NEAR(after(true), 3.0, 0.15);
  EXPECT_LT(after(false), 1.7);
}

}  // namespace
}  // namespace stillray::denoiser_history_test
