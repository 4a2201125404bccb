// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Options, settings files and logs have every row of RenderParameters().
#include <algorithm>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.h"
#include "render/other_value.h"

namespace stillray::cli_tracer_options_test {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> OptionOf(const Parameter& p, const std::string& value) {
  std::string name = p.name;
  std::replace(name.begin(), name.end(), '_', '-');
  if (p.type == ParameterType::kFlag) {
    return {(value == "on" ? "--" : "--no-") + name};
  }
  return {"--" + name, value};
}

std::string DefaultOf(const Parameter& p) {
  return GetRenderParameter({}, p.name).value();
}

/// Renders one small frame. \return its render.json
nlohmann::json Log(const std::string& folder, const std::vector<std::string>& more) {
  std::vector<std::string> all = {"render", "builtin:cornell", "-o", folder,     "--size",
                                  "16x16",  "--frames",        "1",  "--format", "exr"};
  all.insert(all.end(), more.begin(), more.end());
  const ProgramRun run = RunProgram(all);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  return nlohmann::json::parse(ReadText(folder + "/render.json"));
}

/// As GetRenderParameter would have it.
std::string TextOf(const nlohmann::json& value) {
  if (value.is_boolean()) {
    return value.get<bool>() ? "on" : "off";
  }
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// Samples per pixel are a number in the log, 0.125 for 1/8.
std::string InLog(const Parameter& p, const std::string& value) {
  return p.type == ParameterType::kRate && value == "1/8" ? "0.125" : value;
}

TEST(CliTracerOptions, EverySettingIsAnOptionAndInTheLog) {
  const TemporaryFolder folder;
  for (const Parameter& p : RenderParameters()) {
    const std::string other = test::OtherValue(p);
    std::vector<std::string> options = OptionOf(p, other);
    if (std::string(p.name) == "guides") {
      options.insert(options.end(), {"--spp", "1/8"});  // without which there are no sparse guides
    }
    const nlohmann::json log = Log(folder / p.name, options);
    EXPECT_EQ(TextOf(log[p.name]), InLog(p, other)) << p.name;
  }
}

TEST(CliTracerOptions, TheCommandLineGoesBeforeTheFile) {
  const TemporaryFolder folder;
  std::ofstream file(folder / "look.txt");
  std::vector<std::string> defaults = {"--settings", folder / "look.txt"};
  for (const Parameter& p : RenderParameters()) {
    file << "render." << p.name << "=" << test::OtherValue(p) << "\n";
    const std::vector<std::string> option = OptionOf(p, DefaultOf(p));
    defaults.insert(defaults.end(), option.begin(), option.end());
  }
  file.close();
  const nlohmann::json from_file = Log(folder / "file", {"--settings", folder / "look.txt"});
  const nlohmann::json from_options = Log(folder / "options", defaults);
  for (const Parameter& p : RenderParameters()) {
    EXPECT_EQ(TextOf(from_file[p.name]), InLog(p, test::OtherValue(p))) << p.name;
    EXPECT_EQ(TextOf(from_options[p.name]), DefaultOf(p)) << p.name;
  }
}

TEST(CliTracerOptions, EveryCommandThatTracesHasThem) {
  for (const char* command : {"render", "view", "bench"}) {
    const std::string help = RunProgram({command, "--help"}).output;
    for (const Parameter& p : RenderParameters()) {
      for (const std::string& part : OptionOf(p, p.type == ParameterType::kFlag ? "off" : "x")) {
        EXPECT_TRUE(part == "x" || help.find(part) != std::string::npos) << command << " " << part;
      }
    }
  }
}

TEST(CliTracerOptions, ErrorsNameOptionValueAndWhatWasExpected) {
  const auto error = [](const std::vector<std::string>& arguments) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments.back();
    return run.errors;
  };
  const std::string expected =
      "--spp is '2/3', expected 1 to 65536, or 1/2 to 1/256 for one path "
      "per pixel in several frames";
  EXPECT_THAT(error({"render", "builtin:cornell", "-o", "x", "--spp", "2/3"}),
              HasSubstr(expected + "\n"));
  EXPECT_THAT(error({"view", "--headless-frames", "1", "--spp", "2/3"}),
              HasSubstr(expected + ", or auto\n"));
  EXPECT_THAT(error({"view", "--headless-frames", "1", "--sampler", "halton"}),
              HasSubstr("--sampler is 'halton', expected one of sobol, halton16, zsobol, did you "
                        "mean halton16?\n"));
  for (const auto& [option, value] : {std::pair{"--aperture", "-1"},
                                      {"--aperture", "nan"},
                                      {"--aperture", "f/0"},
                                      {"--focus", "0"},
                                      {"--blades", "2"}}) {
    EXPECT_THAT(error({"render", "builtin:cornell", "-o", "x", option, value}),
                HasSubstr(std::string(option) + " is '" + value + "', expected scene"));
  }
  EXPECT_THAT(error({"render", "builtin:cornell", "-o", "x", "--lens-mask", "none.png"}),
              HasSubstr("--lens-mask: none.png: no such file"));
  EXPECT_THAT(error({"bench", "--bounces", "0"}),
              HasSubstr("--bounces is '0', expected a whole number from 1 to 32\n"));
}

}  // namespace
}  // namespace stillray::cli_tracer_options_test
