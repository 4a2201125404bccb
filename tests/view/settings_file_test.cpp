// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/settings_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/other_value.h"

namespace stillray::settings_file_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(SettingsFile, EveryPresetComesBack) {
  for (const std::string_view name : PresetNames()) {
    SettingsFile file;
    file.preset = std::string(name);
    file.denoise = PresetSettings(name).value();
    ASSERT_TRUE(SetParameter(&file.denoise, "sigma_l", "3.14159274").ok());
    ASSERT_TRUE(SetParameter(&file.denoise, "steps", "1,3,9,27,5").ok());
    const std::string text = FormatSettingsFile(file).value();
    const SettingsFile back = ParseSettingsFile(text, "text").value();
    EXPECT_EQ(back.preset, name);
    for (const Parameter& p : Parameters()) {
      EXPECT_EQ(GetParameter(back.denoise, p.name).value(),
                GetParameter(file.denoise, p.name).value());
    }
  }
}

TEST(SettingsFile, HoldsOnlyWhatDiffersFromThePreset) {
  SettingsFile file;
  file.preset = "svgf";
  file.denoise = PresetSettings("svgf").value();
  file.denoise.sigma_n = 77;
  const std::string text = FormatSettingsFile(file).value();
  EXPECT_THAT(text, HasSubstr("preset=svgf\nsigma_n=77\n"));
  EXPECT_THAT(text, Not(HasSubstr("sigma_l")));
}

TEST(SettingsFile, CarriesEverySettingOfTheTracer) {
  SettingsFile file;
  for (const Parameter& p : RenderParameters()) {
    file.render.push_back({p.name, test::OtherValue(p)});
  }
  const SettingsFile back = ParseSettingsFile(FormatSettingsFile(file).value(), "text").value();
  RenderSettings settings;
  ASSERT_TRUE(ApplyRenderLines(back.render, &settings).ok());
  for (const Parameter& p : RenderParameters()) {
    EXPECT_EQ(GetRenderParameter(settings, p.name).value(), test::OtherValue(p)) << p.name;
  }
  EXPECT_TRUE(ParseSettingsFile("preset=svgf", "text")->render.empty());
}

TEST(SettingsFile, SpacesCommentsAndEmptyLinesDoNotCount) {
  const SettingsFile file =
      ParseSettingsFile("\n# a comment\r\n  preset = eaw \r\n\n sigma_l=  2\n#\n", "text").value();
  EXPECT_EQ(file.preset, "eaw");
  EXPECT_FLOAT_EQ(file.denoise.sigma_l, 2);
  EXPECT_EQ(ParseSettingsFile("", "text")->preset, "default");
}

TEST(SettingsFile, ErrorsNameFileLineAndWhatIsExpected) {
  const struct {
    const char* text;
    const char* place;
    const char* word;
  } kCases[] = {{"preset=none", "a.txt:1:", "none"},
                {"sigma_l=2\npreset=svgf", "a.txt:2:", "before all"},
                {"\n\nsigma=2", "a.txt:3:", "'sigma'"},
                {"sigma_l=-1", "a.txt:1:", "-1"},
                {"sigma_l", "a.txt:1:", "'sigma_l' has no '=', expected name=value"},
                {"=", "a.txt:1:", "''"},
                {"render.spp=1/7000", "a.txt:1:", "1/7000"},
                {"render.bounces=0", "a.txt:1:", "render.bounces is '0', expected a whole number"},
                {"render.bounces=4x", "a.txt:1:", "4x"},
                {"render.guides=some", "a.txt:1:", "sparse"},
                {"render.regularise=maybe", "a.txt:1:", "maybe"},
                {"render.colour=red", "a.txt:1:", "render.colour"},
                {"render.bounce=1", "a.txt:1:", "did you mean bounces?"},
                {"feedback=8", "a.txt:", "feedback"}};
  for (const auto& c : kCases) {
    const Result<SettingsFile> file = ParseSettingsFile(c.text, "a.txt");
    ASSERT_FALSE(file.ok()) << c.text;
    EXPECT_EQ(file.status().code(), StatusCode::kBadData) << c.text;
    EXPECT_THAT(file.status().message(), HasSubstr(c.place)) << c.text;
    EXPECT_THAT(file.status().message(), HasSubstr(c.word)) << c.text;
  }
}

TEST(SettingsFile, AnyBytesAreRefusedOrRead) {
  std::string bytes;
  for (int i = 0; i < 4096; ++i) {
    bytes.push_back(static_cast<char>(i * 37 + i / 7));
  }
  EXPECT_FALSE(ParseSettingsFile(bytes, "bytes").ok());
  EXPECT_FALSE(ParseSettingsFile(std::string(100000, '='), "bytes").ok());
  EXPECT_FALSE(ParseSettingsFile(std::string_view("preset=svgf\0x", 13), "bytes").ok());
}

TEST(SettingsFile, FilesThatAreNotThereAreNamed) {
  const Result<SettingsFile> file = ReadSettingsFile("no/such.settings");
  EXPECT_EQ(file.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(file.status().message(), HasSubstr("no/such.settings"));
}

}  // namespace
}  // namespace stillray::settings_file_test
