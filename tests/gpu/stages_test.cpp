// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Every stage on Vulkan against the scalar reference: the pictures between the stages, for all
// kinds of settings, on frames with missing and broken samples, disocclusions and odd sizes.
#include <gmock/gmock.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "denoise/test_frames.h"
#include "gpu/device_test.h"

namespace stillray {
namespace {

using test::MakeBusyFrame;
using test::ToleranceOf;

class Stages : public test::DeviceTest {
 protected:
  void ExpectSame(Settings settings, DevicePrecision precision, int width, int height, int frames,
                  const std::string& what);
};

void Stages::ExpectSame(Settings settings, DevicePrecision precision, int width, int height,
                        int frames, const std::string& what) {
  settings = test::WithoutFxaa(settings);
  Denoiser tested = MakeDenoiser(settings, precision);
  test::ExpectReferencePictures(
      settings, &tested, frames, [&](int i) { return MakeBusyFrame(width, height, i); },
      [&](const std::string& name) { return ToleranceOf(name, precision); }, what);
}

/// All but those with a stage that only the CPU has.
std::vector<std::string_view> DevicePresets() {
  std::vector<std::string_view> names(PresetNames().begin(), PresetNames().end());
  EXPECT_EQ(std::erase(names, "best"), 1u);
  return names;
}

TEST_F(Stages, PresetsInFloats) {
  for (const std::string_view preset : DevicePresets()) {
    ExpectSame(PresetSettings(preset).value(), DevicePrecision::kFloat, 67, 35, 4,
               std::string(preset));
  }
}

TEST_F(Stages, PresetsInHalves) {
  for (const std::string_view preset : DevicePresets()) {
    ExpectSame(PresetSettings(preset).value(), DevicePrecision::kHalf, 67, 35, 4,
               std::string(preset));
  }
}

/// Variants of the wavelet's shader, for the following denoisers.
class Variant {
 public:
  explicit Variant(const char* name) { setenv("STILLRAY_ATROUS", name, 1); }
  ~Variant() { unsetenv("STILLRAY_ATROUS"); }
  Variant(const Variant&) = delete;
  Variant& operator=(const Variant&) = delete;
};

TEST_F(Stages, TilesOfTheWaveletArePlainTaps) {
  const Settings many[] = {
      test::WithoutFxaa(PresetSettings("default").value()),
      test::WithoutFxaa(PresetSettings("svgf").value()),
      test::With("svgf",
                 {{"kernel", "3x3"}, {"wavelet_id", "on"}, {"steps", "3,1,7"}, {"fxaa", "off"}}),
      test::With("default", {{"wavelet", "eaw"}, {"fxaa", "off"}}),
      test::With("default", {{"wavelet", "naive"}, {"fxaa", "off"}})};
  for (const Settings& settings : many) {
    for (const DevicePrecision precision : {DevicePrecision::kFloat, DevicePrecision::kHalf}) {
      const auto picture = [&](const char* variant) {
        const Variant chosen(variant);
        Denoiser denoiser = MakeDenoiser(settings, precision);
        DenoisedFrame out;
        for (int i = 0; i < 3; ++i) {
          EXPECT_TRUE(denoiser.Denoise(test::MakeBusyFrame(61, 37, i), &out).ok());
        }
        return out.colour;
      };
      const Image3 plain = picture("plain");
      const Image3 tiles = picture("tile");
      for (int c = 0; c < 3; ++c) {
        // One rounding of a half, where the compiler of the device fuses other operations.
        const bool halves = precision == DevicePrecision::kHalf;
        const double most = halves ? 5e-4 : 1e-5;
        const test::Difference d = test::Compare(tiles[c], plain[c], most);
        test::RecordLargest(halves ? "tiles in halves rms" : "tiles rms", d.rms, most);
        EXPECT_LE(d.rms, most);
      }
    }
  }
  const Variant unknown("tiles");
  Denoiser denoiser = MakeDenoiser(many[0], DevicePrecision::kFloat);
  DenoisedFrame out;
  EXPECT_THAT(denoiser.Denoise(test::MakeBusyFrame(61, 37, 0), &out).message(),
              ::testing::HasSubstr("STILLRAY_ATROUS is 'tiles', expected plain or tile"));
}

TEST_F(Stages, OtherSettingsInFloats) {
  const std::vector<Settings> all = test::OtherSettings();
  for (size_t i = 0; i < all.size(); ++i) {
    ExpectSame(all[i], DevicePrecision::kFloat, 45, 51, 4, "settings " + std::to_string(i));
  }
}

TEST_F(Stages, SmallAndOddSizes) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{2, 1}, std::pair{1, 9}, std::pair{17, 3}, std::pair{129, 8}}) {
    for (const char* preset : {"default", "svgf", "psvgf"}) {
      ExpectSame(PresetSettings(preset).value(), DevicePrecision::kFloat, width, height, 3,
                 std::string(preset) + " " + std::to_string(width) + "x" + std::to_string(height));
    }
  }
}

}  // namespace
}  // namespace stillray
