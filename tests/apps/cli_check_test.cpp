// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray check as a user runs it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "stillray/io.h"

namespace stillray::cli_check_test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class CliCheck : public testing::Test {
 protected:
  void SetUp() override {
    const ProgramRun run =
        RunProgram({"render", "builtin:cornell", "-o", folder_.path(), "--save-inputs", "--size",
                    "96x54", "--frames", "1-3", "--format", "exr"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
  }

  std::string Pattern() const { return folder_ / "noisy.####.exr"; }

  /// Puts a NaN into the albedo of frame 2.
  void Spoil() const {
    const std::string path = folder_ / "noisy.0002.exr";
    Result<ExrImage> image = ReadExr(path);
    ASSERT_TRUE(image.ok()) << image.status().message();
    for (Channel& channel : image->channels) {
      if (channel.name == "albedo.R") {
        channel.values(10, 20) = std::nanf("");
      }
    }
    ASSERT_TRUE(WriteExr(path, *image).ok());
  }

  void ExpectFailure(const ProgramRun& run, const std::string& what) const {
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr(what));
    EXPECT_THAT(run.errors, StartsWith("stillray: error: "));
    EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
  }

  TemporaryFolder folder_;
};

TEST_F(CliCheck, CleanFramesExitWith0) {
  const ProgramRun run = RunProgram({"check", Pattern()});
  EXPECT_EQ(run.exit_code, 0) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("understood as frames of stillray"));
  EXPECT_THAT(run.output, HasSubstr("3 frames: nothing wrong was found"));
  EXPECT_THAT(run.errors, IsEmpty());
}

TEST_F(CliCheck, FindingsExitWith3AndTellTheCure) {
  Spoil();
  const ProgramRun run = RunProgram({"check", Pattern(), "--measures"});
  EXPECT_EQ(run.exit_code, 3) << run.output << run.errors;
  EXPECT_THAT(run.output, HasSubstr("\nnot_finite\n"));
  EXPECT_THAT(run.output, HasSubstr("albedo.R of frame 2 at x 10, y 20"));
  EXPECT_THAT(run.output, HasSubstr("\n  cure: "));
  EXPECT_THAT(run.output, HasSubstr("not_finite_values"));
  EXPECT_THAT(run.output, HasSubstr("3 frames: 1 finding\n"));
}

TEST_F(CliCheck, JsonOnStandardOutputIsNothingElse) {
  Spoil();
  const ProgramRun run = RunProgram({"check", Pattern(), "--json", "-"});
  EXPECT_EQ(run.exit_code, 3);
  const json report = json::parse(run.output);
  EXPECT_EQ(report["clean"], false);
  EXPECT_EQ(report["renderer"], "stillray");
  EXPECT_EQ(report["frames"], json({1, 2, 3}));
  ASSERT_EQ(report["findings"].size(), 1u);
  EXPECT_EQ(report["findings"][0]["name"], "not_finite");
  EXPECT_EQ(report["findings"][0]["frames"], json({2}));
  EXPECT_EQ(report["findings"][0]["measured"], 1);
  EXPECT_FALSE(report["findings"][0].contains("aov"));
  EXPECT_GT(report["measures"].size(), 10u);
}

TEST_F(CliCheck, JsonInAFile) {
  const std::string path = folder_ / "report.json";
  EXPECT_EQ(RunProgram({"check", Pattern(), "--json", path}).exit_code, 0);
  EXPECT_EQ(json::parse(ReadText(path))["clean"], true);
}

TEST_F(CliCheck, TheSameForAnyThreads) {
  const ProgramRun one = RunProgram({"check", Pattern(), "--measures", "--threads", "1"});
  const ProgramRun four = RunProgram({"check", Pattern(), "--measures", "--threads", "4"});
  EXPECT_EQ(one.output, four.output);
}

TEST_F(CliCheck, AListWithAGap) {
  const ProgramRun run =
      RunProgram({"check", folder_ / "noisy.0001.exr", folder_ / "noisy.0003.exr"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.output, HasSubstr("frame 2 is not there, between 1 and 3"));
}

TEST_F(CliCheck, DenoisedFramesLackGuides) {
  const ProgramRun alone = RunProgram({"check", folder_ / "denoised.####.exr"});
  EXPECT_EQ(alone.exit_code, 3);
  EXPECT_THAT(alone.output, HasSubstr("single_layer"));
  const std::string more = folder_ / "more";
  ASSERT_EQ(RunProgram({"render", "builtin:cornell", "-o", more, "--size", "96x54", "--frames",
                        "1-3", "--format", "exr", "--aov", "motion,depth"})
                .exit_code,
            0);
  const ProgramRun run = RunProgram({"check", more + "/denoised.####.exr"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.output, HasSubstr("albedo_missing"));
}

TEST_F(CliCheck, UnreadableInputExitsWith2) {
  ExpectFailure(RunProgram({"check", folder_ / "nothing.####.exr"}), "no file matches");
  ExpectFailure(RunProgram({"check", folder_.path()}), "holds 2 sequences");
  ExpectFailure(RunProgram({"check", Pattern(), "--frames", "9-12"}), "--frames is '9-12'");
  ExpectFailure(RunProgram({"check", Pattern(), "--renderer", "none"}), "--renderer is 'none'");
  std::ofstream(folder_ / "noisy.0002.exr") << "no picture";
  const ProgramRun run = RunProgram({"check", Pattern()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("noisy.0002.exr"));
}

TEST_F(CliCheck, AMappingIsLookedAt) {
  const ProgramRun run =
      RunProgram({"check", Pattern(), "--aov", "normal=normal,encoded", "--aov", "id=none"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.output, HasSubstr("normal_not_encoded"));
  EXPECT_THAT(run.output, HasSubstr("--aov 'normal=normal,world,signed'"));
  EXPECT_EQ(RunProgram({"check", Pattern(), "--aov", "normal=normal,world,signed"}).exit_code, 0);
}

TEST(CliCheckHelp, HasExamplesAndExitCodes) {
  const ProgramRun run = RunProgram({"check", "--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.output, HasSubstr("Exit code: 0"));
  EXPECT_THAT(run.output, HasSubstr("stillray check 'shot.####.exr'"));
  EXPECT_THAT(run.errors, Not(HasSubstr("error")));
}

}  // namespace
}  // namespace stillray::cli_check_test
