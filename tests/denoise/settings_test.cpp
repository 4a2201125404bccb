// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/denoise.hpp"

namespace stillray {
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
  EXPECT_THAT(message("kernel", "7x7"), HasSubstr("one of 3x3, 5x5"));
  EXPECT_THAT(message("temporal", "maybe"), HasSubstr("on or off"));
  EXPECT_THAT(message("steps", "1,2,"), HasSubstr("whole numbers from 1 to 64"));
  EXPECT_THAT(message("steps", "1,2,3,4,5,6,7,8,9"), HasSubstr("1 to 8 whole numbers"));
  EXPECT_THAT(message("steps", ""), HasSubstr("whole numbers"));
  EXPECT_THAT(message("sigma_m", "1"), HasSubstr("unknown parameter 'sigma_m'"));
  EXPECT_THAT(PresetSettings("best").status().message(),
              HasSubstr("presets are: default, svgf, psvgf, eaw, temporal"));
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
}  // namespace stillray
