// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Every stage on Vulkan against the scalar reference: the pictures between the stages, for all
// kinds of settings, on frames with missing and broken samples, disocclusions and odd sizes.
#include <map>
#include <vector>

#include "denoise/test_frames.h"
#include "gpu/device_test.h"

namespace stillray {
namespace {

using test::MakeBusyFrame;
using test::ToleranceOf;
using test::With;

class Stages : public test::DeviceTest {
 protected:
  void ExpectSame(Settings settings, DevicePrecision precision, int width, int height, int frames,
                  const std::string& what);
};

void Stages::ExpectSame(Settings settings, DevicePrecision precision, int width, int height,
                        int frames, const std::string& what) {
  settings.fxaa = Fxaa::kOff;  // decides at thresholds: see Fxaa below
  Result<Denoiser> reference = Denoiser::Create(settings, Backend::kReference);
  ASSERT_TRUE(reference.ok());
  Denoiser tested = MakeDenoiser(settings, precision);
  const std::vector<std::string> names = Denoiser::OutputNames(settings);
  ASSERT_TRUE(reference->SetOutputs(names).ok());
  ASSERT_TRUE(tested.SetOutputs(names).ok());
  for (int i = 0; i < frames; ++i) {
    const Frame frame = MakeBusyFrame(width, height, i);
    DenoisedFrame expected;
    DenoisedFrame got;
    ASSERT_TRUE(reference->Denoise(frame, &expected).ok());
    const Status status = tested.Denoise(frame, &got);
    ASSERT_TRUE(status.ok()) << what << ": " << status.message();
    EXPECT_EQ(got.non_finite, expected.non_finite) << what;
    EXPECT_EQ(got.negative, expected.negative) << what;
    EXPECT_EQ(got.bad_guides, expected.bad_guides) << what;
    std::map<std::string, const NamedImage*> images;
    for (const NamedImage& image : got.images) {
      images[image.name] = &image;
    }
    const std::string where = what + " frame " + std::to_string(i);
    for (const NamedImage& image : expected.images) {
      if (settings.wavelet != Wavelet::kSvgf && image.name.find("variance.") == 9) {
        continue;  // filtered_variance is undefined for wavelets without a variance
      }
      ASSERT_TRUE(images.contains(image.name)) << where << " lacks " << image.name;
      ExpectImage(*images[image.name], image, ToleranceOf(image.name, precision), where);
    }
    const NamedImage colour = {"colour", {got.colour[0], got.colour[1], got.colour[2]}};
    ExpectImage(colour, {"colour", {expected.colour[0], expected.colour[1], expected.colour[2]}},
                ToleranceOf("colour", precision), where);
  }
}

TEST_F(Stages, PresetsInFloats) {
  for (const std::string_view preset : PresetNames()) {
    ExpectSame(PresetSettings(preset).value(), DevicePrecision::kFloat, 67, 35, 4,
               std::string(preset));
  }
}

TEST_F(Stages, PresetsInHalves) {
  for (const std::string_view preset : PresetNames()) {
    ExpectSame(PresetSettings(preset).value(), DevicePrecision::kHalf, 67, 35, 4,
               std::string(preset));
  }
}

TEST_F(Stages, OtherSettingsInFloats) {
  const std::vector<Settings> all = {
      With("default", {{"wavelet", "naive"}}),
      With("default", {{"wavelet", "eaw"}, {"steps", "2,1"}}),
      With("default", {{"kernel", "3x3"},
                       {"depth_weight", "gradient"},
                       {"max_slope", "0.01"},
                       {"feedback", "2"}}),
      With("default",
           {{"short_history", "blur"}, {"luminance", "rec601"}, {"luminance_scale", "variance"}}),
      With("default", {{"signals", "single"}, {"demodulate", "off"}, {"firefly", "clamp"}}),
      With("svgf", {{"firefly", "compress"},
                    {"wavelet_id", "on"},
                    {"steps", "4,2,1"},
                    {"prefilter_variance", "off"}}),
      With("default",
           {{"signals", "diffuse_specular"}, {"history_search", "off"}, {"max_history", "5"}}),
      With("svgf", {{"antialias", "off"}, {"history_id", "off"}, {"feedback", "2"}}),
  };
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
