// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Every stage on Vulkan against the scalar reference: the pictures between the stages, for all
// kinds of settings, on frames with missing and broken samples, disocclusions and odd sizes.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "denoise/test_frames.h"
#include "gpu/device_test.h"

namespace stillray::stages_test {
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

/// Sixteen samples in each pixel that has any. Without `all_moments` the last signal lacks second
/// moments, which are then estimated.
Frame SeveralSamples(int width, int height, int index, bool all_moments = false) {
  Frame f = MakeBusyFrame(width, height, index);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      f.samples(x, y) *= 16;
    }
  }
  for (size_t i = 0; i < f.signals.size() - (all_moments ? 0 : 1); ++i) {
    const Image3& light = f.signals[i].radiance;
    Image1& moment = f.signals[i].second_moment;
    moment = Image1(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const float u =
            test::Random(static_cast<uint32_t>(index), static_cast<uint32_t>(y * width + x), 200);
        const float luminance =
            0.2126f * light[0](x, y) + 0.7152f * light[1](x, y) + 0.0722f * light[2](x, y);
        moment(x, y) = (1.0f + u) * luminance * luminance;
      }
    }
  }
  return f;
}

TEST_F(Stages, SamplesAreKept) {
  const Settings settings = test::WithoutFxaa(Settings());
  Settings off = settings;
  off.keep_samples = false;
  Denoiser tested = MakeDenoiser(settings, DevicePrecision::kFloat);
  test::ExpectReferencePictures(
      settings, &tested, 4, [&](int i) { return SeveralSamples(67, 35, i); },
      [&](const std::string& name) { return ToleranceOf(name, DevicePrecision::kFloat); },
      "several samples");
  // With all second moments none is estimated, and what sticks out is not limited.
  Denoiser given = MakeDenoiser(settings, DevicePrecision::kFloat);
  test::ExpectReferencePictures(
      settings, &given, 4, [&](int i) { return SeveralSamples(67, 35, i, true); },
      [&](const std::string& name) { return ToleranceOf(name, DevicePrecision::kFloat); },
      "several samples, all moments");
  // Halves hold the squares less well than light: the last pictures alone. With 16 samples a
  // history ends soon after a difference exceeds its noise, which halves round by a thousandth.
  const auto picture = [&](Denoiser denoiser) {
    DenoisedFrame out;
    for (int i = 0; i < 4; ++i) {
      EXPECT_TRUE(denoiser.Denoise(SeveralSamples(67, 35, i), &out).ok());
    }
    return out.colour;
  };
  const Image3 floats = picture(MakeDenoiser(settings, DevicePrecision::kFloat));
  const Image3 halves = picture(MakeDenoiser(settings, DevicePrecision::kHalf));
  const Image3 without = picture(MakeDenoiser(off, DevicePrecision::kFloat));
  constexpr double kHalves = 0.03;
  constexpr double kChange = 4e-3;
  for (int c = 0; c < 3; ++c) {
    const double rms = test::Compare(halves[c], floats[c], kHalves).rms;
    test::RecordLargest("several samples in halves rms", rms, kHalves);
    EXPECT_LE(rms, kHalves);
    EXPECT_GT(test::Compare(without[c], floats[c], kChange).rms, kChange);
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

TEST_F(Stages, NormalsOfTheOtherFormat) {
  for (const char* preset : {"default", "svgf", "psvgf", "eaw"}) {
    for (const auto& [precision, normals] :
         {std::pair{DevicePrecision::kHalf, "plain"}, {DevicePrecision::kFloat, "octahedral"}}) {
      ExpectSame(test::With(preset, {{"normals", normals}}), precision, 67, 35, 4,
                 std::string(preset) + " " + normals);
    }
  }
}

// auto is what each precision is made for, and the other way differs.
TEST_F(Stages, NormalsAreThoseOfThePrecisionByDefault) {
  for (const DevicePrecision precision : {DevicePrecision::kHalf, DevicePrecision::kFloat}) {
    const auto picture = [&](const char* normals) {
      Denoiser denoiser = MakeDenoiser(test::With("default", {{"normals", normals}}), precision);
      DenoisedFrame out;
      for (int i = 0; i < 3; ++i) {
        EXPECT_TRUE(denoiser.Denoise(MakeBusyFrame(61, 37, i), &out).ok());
      }
      return std::pair(std::move(out.colour), denoiser.memory_bytes());
    };
    const bool half = precision == DevicePrecision::kHalf;
    const auto by_default = picture("auto");
    const auto same = picture(half ? "octahedral" : "plain");
    const auto other = picture(half ? "plain" : "octahedral");
    EXPECT_TRUE(test::SameBits(by_default.first, same.first));
    EXPECT_FALSE(test::SameBits(by_default.first, other.first));
    EXPECT_EQ(by_default.second, same.second);
    EXPECT_EQ(other.second > same.second, half);
    EXPECT_EQ(other.second < same.second, !half);
  }
}

/// Ridges, over which the normal turns by 0.3 radians per pixel.
Frame Ridges(int width, int height, int index) {
  Frame f = MakeBusyFrame(width, height, index);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float angle = 0.3f * static_cast<float>(x % 9 - 4);
      f.guides.normal[0](x, y) = std::sin(angle);
      f.guides.normal[1](x, y) = 0;
      f.guides.normal[2](x, y) = std::cos(angle);
    }
  }
  return f;
}

// There the normal weight of specular light differs from that of other light.
TEST_F(Stages, SpecularLightOnStrongTurns) {
  for (const DevicePrecision precision : {DevicePrecision::kFloat, DevicePrecision::kHalf}) {
    for (const char* signals : {"split", "diffuse_specular", "single"}) {
      const Settings settings = test::WithoutFxaa(test::With("default", {{"signals", signals}}));
      Denoiser tested = MakeDenoiser(settings, precision);
      test::ExpectReferencePictures(
          settings, &tested, 3, [](int i) { return Ridges(67, 35, i); },
          [&](const std::string& name) { return ToleranceOf(name, precision); }, signals);
    }
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
}  // namespace stillray::stages_test
