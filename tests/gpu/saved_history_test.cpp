// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Histories that leave the device as bytes and come back.
#include <gmock/gmock.h>

#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "denoise/sparse_frames.h"
#include "denoise/test_frames.h"
#include "gpu/device_test.h"

namespace stillray::saved_history_test {
namespace {

using test::MakeBusyFrame;
using test::With;
using ::testing::HasSubstr;

class SavedHistory : public test::DeviceTest {
 protected:
  /// Frames 0 to 5 in one go, and 3 to 5 after a history that was saved behind frame 2.
  template <typename MakeFrame>
  void ExpectTheSameBits(const Settings& settings, DevicePrecision precision,
                         const MakeFrame& make) {
    Denoiser whole = MakeDenoiser(settings, precision);
    DenoisedFrame expected;
    DenoisedFrame out;
    std::vector<uint8_t> saved;
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(whole.Denoise(make(i), &expected).ok());
      if (i == 2) {
        saved = whole.SaveHistory().value();
      }
    }
    Denoiser resumed = MakeDenoiser(settings, precision);
    // Independent of its earlier frames.
    ASSERT_TRUE(resumed.Denoise(MakeBusyFrame(16, 9, 0), &out).ok());
    const Status restored = resumed.RestoreHistory(saved);
    ASSERT_TRUE(restored.ok()) << restored.message();
    EXPECT_EQ(resumed.SaveHistory().value(), saved);
    EXPECT_EQ(resumed.ReadColour(&out.colour).code(), StatusCode::kNotFound);
    for (int i = 3; i < 6; ++i) {
      ASSERT_TRUE(resumed.Denoise(make(i), &out).ok());
    }
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < out.colour.height(); ++y) {
        ASSERT_EQ(std::memcmp(out.colour[c].Row(y), expected.colour[c].Row(y),
                              sizeof(float) * static_cast<size_t>(out.colour.width())),
                  0)
            << "channel " << c << " row " << y;
      }
    }
    EXPECT_EQ(resumed.SaveHistory().value(), whole.SaveHistory().value());
  }
};

TEST_F(SavedHistory, ContinuesWithTheSameBits) {
  for (const auto& [preset, precision] : {std::pair{"default", DevicePrecision::kHalf},
                                          {"default", DevicePrecision::kFloat},
                                          {"svgf", DevicePrecision::kHalf}}) {
    SCOPED_TRACE(preset);
    ExpectTheSameBits(PresetSettings(preset).value(), precision,
                      [](int i) { return MakeBusyFrame(41, 23, i); });
  }
}

TEST_F(SavedHistory, HoldsNormalsOfEitherFormat) {
  for (const auto& [normals, precision] :
       {std::pair{"plain", DevicePrecision::kHalf}, {"octahedral", DevicePrecision::kFloat}}) {
    SCOPED_TRACE(normals);
    ExpectTheSameBits(With("default", {{"normals", normals}}), precision,
                      [](int i) { return MakeBusyFrame(41, 23, i); });
  }
}

TEST_F(SavedHistory, HoldsTheGuidesOfSparseFrames) {
  for (const char* preset : {"default", "psvgf"}) {
    SCOPED_TRACE(preset);
    ExpectTheSameBits(PresetSettings(preset).value(), DevicePrecision::kHalf, [](int i) {
      return test::MakeSparseFrame({37, 21, 4, 0.6f, true}, i);
    });
  }
}

TEST_F(SavedHistory, OfFramesWithoutHistoryIsAFirstFrame) {
  ExpectTheSameBits(With("default", {{"temporal", "off"}}), DevicePrecision::kHalf,
                    [](int i) { return MakeBusyFrame(19, 8, i); });
  Denoiser d = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kHalf);
  const std::vector<uint8_t> nothing = d.SaveHistory().value();
  EXPECT_FALSE(nothing.empty());
  EXPECT_THAT(d.RestoreHistory(nothing).message(), HasSubstr("claims a size of 0x0"));
}

TEST_F(SavedHistory, DamagedOrOfOtherSettingsIsRefusedAndChangesNothing) {
  Denoiser d = MakeDenoiser(PresetSettings("default").value(), DevicePrecision::kHalf);
  DenoisedFrame out;
  ASSERT_TRUE(d.Denoise(MakeBusyFrame(16, 16, 0), &out).ok());
  const std::vector<uint8_t> saved = d.SaveHistory().value();
  const auto refused = [&](std::span<const uint8_t> bytes) {
    const Status status = d.RestoreHistory(bytes);
    EXPECT_EQ(status.code(), StatusCode::kBadData);
    EXPECT_EQ(d.SaveHistory().value(), saved);
    return status.message();
  };
  const auto all = std::span<const uint8_t>(saved);
  EXPECT_THAT(refused({}), HasSubstr("0 bytes, expected at least 48"));
  EXPECT_THAT(refused(all.first(47)), HasSubstr("47 bytes"));
  EXPECT_THAT(refused(all.first(saved.size() - 1)), HasSubstr("bytes, expected"));
  for (size_t at = 0; at < saved.size(); at += at < 60 ? 1 : saved.size() / 19) {
    std::vector<uint8_t> flipped = saved;
    flipped[at] ^= 0x10;
    EXPECT_NE(refused(flipped), "") << at;
  }
  const auto message = [&](const Settings& settings, DevicePrecision precision) {
    return std::string(MakeDenoiser(settings, precision).RestoreHistory(saved).message());
  };
  EXPECT_THAT(message(PresetSettings("svgf").value(), DevicePrecision::kHalf),
              HasSubstr("made with limit_history on, the settings have it off"));
  EXPECT_THAT(message(With("default", {{"signals", "single"}}), DevicePrecision::kHalf),
              HasSubstr("3 signals, the settings ask for 1"));
  EXPECT_THAT(message(With("default", {{"normals", "plain"}}), DevicePrecision::kHalf),
              HasSubstr("has octahedral normals, this denoiser keeps plain ones"));
  EXPECT_EQ(message(With("default", {{"normals", "octahedral"}}), DevicePrecision::kHalf), "");
  EXPECT_THAT(message(PresetSettings("default").value(), DevicePrecision::kFloat),
              HasSubstr("saved history is of 16 bits, this denoiser keeps 32"));
}

TEST_F(SavedHistory, OfTheCpuAndOfTheDeviceAreTwoThings) {
  const Settings settings = PresetSettings("default").value();
  Denoiser cpu = std::move(Denoiser::Create(settings).value());
  Denoiser device = MakeDenoiser(settings, DevicePrecision::kHalf);
  DenoisedFrame out;
  ASSERT_TRUE(cpu.Denoise(MakeBusyFrame(16, 16, 0), &out).ok());
  ASSERT_TRUE(device.Denoise(MakeBusyFrame(16, 16, 0), &out).ok());
  const Status to_device = device.RestoreHistory(cpu.SaveHistory().value());
  EXPECT_EQ(to_device.code(), StatusCode::kBadData);
  EXPECT_THAT(to_device.message(), HasSubstr("made on the CPU, this denoiser works on a device"));
  const Status to_cpu = cpu.RestoreHistory(device.SaveHistory().value());
  EXPECT_EQ(to_cpu.code(), StatusCode::kBadData);
  EXPECT_THAT(to_cpu.message(),
              HasSubstr("made on a Vulkan device, this denoiser works on the CPU"));
}

}  // namespace
}  // namespace stillray::saved_history_test
