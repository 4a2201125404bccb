// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/denoise.hpp"

namespace stillray::settings_test {
namespace {

using ::testing::HasSubstr;

TEST(Settings, DefaultPresetIsTheStruct) {
  const Result<Settings> preset = PresetSettings("default");
  ASSERT_TRUE(preset.ok());
  for (const Parameter& p : Parameters()) {
    EXPECT_EQ(GetParameter(*preset, p.name).value(), GetParameter(Settings(), p.name).value())
        << p.name;
  }
}

TEST(Settings, EveryPresetIsValidAndEveryValueReadsBack) {
  for (const std::string_view name : PresetNames()) {
    const Result<Settings> preset = PresetSettings(name);
    ASSERT_TRUE(preset.ok()) << preset.status().message();
    EXPECT_TRUE(ValidateSettings(*preset).ok()) << name;
    Settings copy;
    for (const Parameter& p : Parameters()) {
      const std::string text = GetParameter(*preset, p.name).value();
      EXPECT_TRUE(SetParameter(&copy, p.name, text).ok()) << p.name << "=" << text;
      EXPECT_EQ(GetParameter(copy, p.name).value(), text);
    }
  }
}

TEST(Settings, PublishedValuesOfSvgf) {
  const Settings svgf = PresetSettings("svgf").value();
  EXPECT_EQ(svgf.alpha_min, 0.2f);
  EXPECT_EQ(svgf.sigma_n, 128.0f);
  EXPECT_EQ(svgf.sigma_z, 1.0f);
  EXPECT_EQ(svgf.sigma_l, 4.0f);
  EXPECT_EQ(svgf.feedback, 1);
  EXPECT_EQ(svgf.variance_of, VarianceOf::kFrame);
  EXPECT_EQ(GetParameter(svgf, "steps").value(), "1,2,4,8,16");
}

// Dundr 2018; docs/references.md names the sections. One row per value that the paper gives.
TEST(Settings, PublishedValuesOfPsvgf) {
  const Settings psvgf = PresetSettings("psvgf").value();
  const std::pair<const char*, const char*> kPublished[] = {
      {"signals", "single"},
      {"history_weight", "age"},
      {"alpha_min", "0.1"},
      {"alpha_moments", "0.1"},
      {"luminance", "rec601"},
      {"prefilter_variance", "on"},
      {"kernel", "3x3"},
      {"steps", "16,8,4,2,1"},  // large scales first
      {"feedback", "5"},        // the finest level
      {"sigma_n", "64"},
      {"depth_weight", "gradient"},
      {"sigma_z", "1"},
      {"max_slope", "0.1"},
      {"sigma_l", "4"},
      {"luminance_scale", "variance"},
      {"luminance_epsilon", "0.05"},
      {"short_history", "blur"},
      {"antialias", "auto"},  // of jittered frames
      {"taa_alpha", "0.1"},
      {"taa_moving_alpha", "0"},
      {"taa_filter", "catmull_rom"},
      {"taa_extrapolate_motion", "off"},
      {"taa_clamp", "picture"},
      {"taa_follow_light", "off"},
      {"dither", "1"},
      {"fill_guides", "on"},
      {"feedback_when", "blend"},
      {"fxaa", "sparse"},
      {"limit_history", "off"},
      {"clip_outliers", "0"},
      {"restore_energy", "off"},
      {"mirror_roughness", "0"}};
  for (const auto& [name, value] : kPublished) {
    EXPECT_EQ(GetParameter(psvgf, name).value(), value) << name;
  }
}

// SVGF goes from small to large scales and keeps the first level as history, PSVGF the other way.
TEST(Settings, OrderOfLevelsOfEveryPreset) {
  for (const std::string_view preset : PresetNames()) {
    const Settings settings = PresetSettings(preset).value();
    const StepList& list = settings.steps;
    const auto begin = list.step.begin();
    if (preset == "psvgf") {
      EXPECT_TRUE(std::is_sorted(begin, begin + list.count, std::greater<>()));
      EXPECT_EQ(settings.feedback, list.count);
    } else {
      EXPECT_TRUE(std::is_sorted(begin, begin + list.count)) << preset;
      EXPECT_LE(settings.feedback, 1) << preset;
    }
  }
}

TEST(Settings, ErrorsNameParameterValueAndRange) {
  Settings s;
  const auto message = [&](const char* name, const char* value) {
    const Settings before = s;
    const Status status = SetParameter(&s, name, value);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << name << "=" << value;
    EXPECT_EQ(GetParameter(s, "alpha_min").value(), GetParameter(before, "alpha_min").value());
    return status.message();
  };
  EXPECT_THAT(message("alpha_min", "2"),
              HasSubstr("'alpha_min' is '2', expected a number from 0 to 1"));
  EXPECT_THAT(message("alpha_min", "nan"), HasSubstr("expected a number"));
  EXPECT_THAT(message("alpha_min", "0.1x"), HasSubstr("expected a number"));
  EXPECT_THAT(message("kernel", "7x7"), HasSubstr("expected 3x3 or 5x5"));
  EXPECT_THAT(message("temporal", "maybe"), HasSubstr("on or off"));
  EXPECT_THAT(message("steps", "1,2,"), HasSubstr("whole numbers from 1 to 64"));
  EXPECT_THAT(message("steps", "1,2,3,4,5,6,7,8,9"), HasSubstr("1 to 8 whole numbers"));
  EXPECT_THAT(message("steps", ""), HasSubstr("whole numbers"));
  EXPECT_THAT(message("sigma_m", "1"),
              HasSubstr("unknown parameter 'sigma_m', did you mean sigma_"));
  EXPECT_EQ(message("sigmal", "3"), "unknown parameter 'sigmal', did you mean sigma_l?");
  EXPECT_EQ(message("blue", "3"), "unknown parameter 'blue'; docs/parameters.md lists all of them");
  EXPECT_EQ(message("alpha_min", "1e-50"),
            "parameter 'alpha_min' is '1e-50', which is too near to 0 for a 32-bit float");
  EXPECT_THAT(PresetSettings("nicest").status().message(),
              HasSubstr("presets are: default, best, svgf, psvgf, eaw, temporal"));
}

TEST(Settings, ContradictionsAndOutOfRangeStructsAreFound) {
  Settings s;
  s.feedback = 4;
  EXPECT_TRUE(ValidateSettings(s).ok());
  s.steps.count = 3;
  EXPECT_THAT(ValidateSettings(s).message(), HasSubstr("'steps' has only 3 levels"));
  s = Settings();
  s.kernel = static_cast<Kernel>(9);
  EXPECT_THAT(ValidateSettings(s).message(), HasSubstr("'kernel' is '9'"));
  s = Settings();
  s.sigma_l = -1;
  EXPECT_THAT(ValidateSettings(s).message(), HasSubstr("'sigma_l' is '-1'"));
}

}  // namespace
}  // namespace stillray::settings_test
