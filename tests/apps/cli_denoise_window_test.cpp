// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise --window both, and --resume with and without it.
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_window_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Denoises `in` into the folder `out`; files are called f.####.exr.
ProgramRun Denoise(const std::string& in, const std::string& out,
                   const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"denoise", in, "-o", out + "/f.####.exr"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunProgram(arguments);
}

void DenoiseWell(const std::string& in, const std::string& out,
                 const std::vector<std::string>& more) {
  const ProgramRun run = Denoise(in, out, more);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
}

/// Frames of first..last whose files differ in the two folders.
std::vector<int64_t> Differences(const std::string& a, const std::string& b, int64_t first,
                                 int64_t last) {
  std::vector<int64_t> different;
  for (int64_t frame = first; frame <= last; ++frame) {
    const std::string name = FrameFileName("/f.####.exr", frame);
    EXPECT_TRUE(fs::exists(a + name)) << a + name;
    if (ReadText(a + name) != ReadText(b + name)) {
      different.push_back(frame);
    }
  }
  return different;
}

double Decibels(double ratio) {
  return 10 * std::log10(ratio);
}

// Motion to the next frame from a layer and derived motion must be equivalent here.
TEST(CliDenoiseWindow, FirstFramesAreAsCleanAsTheRest) {
  for (const bool forward : {true, false}) {
    const TemporaryFolder folder;
    Shot shot;
    shot.forward = forward;
    const std::string in = folder / "in.####.exr";
    WriteShot(in, shot, 1, 18);
    DenoiseWell(in, folder / "past", {"--window", "past"});
    DenoiseWell(in, folder / "both", {"--window", "both"});
    const std::string past = folder / "past/f.####.exr";
    const std::string both = folder / "both/f.####.exr";
    EXPECT_GT(Decibels(ShotError(past, shot, 1) / ShotError(both, shot, 1)), 3.0);
    // In the middle, where both sides are known, twice the samples bring up to 3 dB.
    EXPECT_GT(Decibels(ShotError(past, shot, 9, 12) / ShotError(both, shot, 9, 12)), 1.0);
    // The last frame has no future.
    EXPECT_THAT(Differences(folder / "past", folder / "both", 18, 18), ::testing::IsEmpty());
  }
}

TEST(CliDenoiseWindow, LightWithoutNoiseStaysAsItIs) {
  const TemporaryFolder folder;
  Shot shot;
  shot.noisy = false;
  shot.contrast = 0;
  WriteShot(folder / "in.####.exr", shot, 1, 6);
  DenoiseWell(folder / "in.####.exr", folder / "out", {"--window", "both"});
  for (const int64_t frame : {1, 4, 6}) {
    EXPECT_LT(ShotError(folder / "out/f.####.exr", shot, frame), 1e-8);
  }
}

// A frame depends on 16 frames past the end of its block of 16 and on no more.
TEST(CliDenoiseWindow, LooksAheadAsFarAsDocumented) {
  const TemporaryFolder folder;
  WriteShot(folder / "in.####.exr", Shot(), 1, 36);
  const std::string in = folder / "in.####.exr";
  DenoiseWell(in, folder / "all", {"--window", "both"});
  DenoiseWell(in, folder / "some", {"--window", "both", "--frames", "1-32"});
  std::vector<int64_t> changed;
  for (int64_t frame = 17; frame <= 32; ++frame) {
    changed.push_back(frame);
  }
  EXPECT_EQ(Differences(folder / "all", folder / "some", 1, 32), changed);
}

TEST(CliDenoiseWindow, MemoryLimitChangesNoBits) {
  const TemporaryFolder folder;
  WriteShot(folder / "in.####.exr", Shot(), 1, 20);
  const std::string in = folder / "in.####.exr";
  DenoiseWell(in, folder / "all", {"--window", "both"});
  // The least that is enough: one frame's future at a time.
  const ProgramRun refused =
      Denoise(in, folder / "less", {"--window", "both", "--memory-limit", "1M"});
  EXPECT_EQ(refused.exit_code, 2);
  const std::string marker = "takes about ";
  const size_t at = refused.errors.find(marker);
  ASSERT_NE(at, std::string::npos) << refused.errors;
  const double megabytes = std::stod(refused.errors.substr(at + marker.size()));
  DenoiseWell(in, folder / "less",
              {"--window", "both", "--memory-limit", std::to_string(megabytes + 0.1) + "M"});
  EXPECT_THAT(Differences(folder / "all", folder / "less", 1, 20), ::testing::IsEmpty());
}

TEST(CliDenoiseWindow, NoLightComesOverCutsAndGaps) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  Shot other;
  other.depth = 9;
  other.normal_axis = 0;
  WriteShot(in, Shot(), 1, 4);
  WriteShot(in, other, 5, 8);    // a cut
  WriteShot(in, other, 11, 13);  // a gap
  DenoiseWell(in, folder / "all", {"--window", "both"});
  for (const auto& [first, last] : {std::pair{1, 4}, {5, 8}, {11, 13}}) {
    const std::string part = folder / ("part" + std::to_string(first));
    DenoiseWell(
        in, part,
        {"--window", "both", "--frames", std::to_string(first) + "-" + std::to_string(last)});
    EXPECT_THAT(Differences(folder / "all", part, first, last), ::testing::IsEmpty()) << first;
  }
}

// Depth, normal and motion are those of the previous shot; only the albedo differs.
TEST(CliDenoiseWindow, ACutBetweenTwoFlatWallsIsSeenByTheirColour) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  Shot white;
  white.colour = 0.9f;
  WriteShot(in, Shot(), 1, 3);
  WriteShot(in, white, 4, 6);
  const ProgramRun run = Denoise(in, folder / "all", {});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("note: frame 4: hardly anything of the frame before"));
  DenoiseWell(in, folder / "part", {"--frames", "4-6"});
  EXPECT_THAT(Differences(folder / "all", folder / "part", 4, 6), ::testing::IsEmpty());
}

TEST(CliDenoiseWindow, WithoutMotionThereIsNoFuture) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, Shot(), 1, 2);
  const ProgramRun run = Denoise(in, folder / "out", {"--window", "both", "--aov", "motion=none"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("without history there is no future either"));
  const ProgramRun wrong = Denoise(in, folder / "out", {"--window", "future"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("--window: found 'future', expected auto, past or both"));
}

class CliDenoiseResume : public ::testing::TestWithParam<const char*> {};

TEST_P(CliDenoiseResume, GoesOnWithTheSameBits) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, Shot(), 1, 60);
  const std::vector<std::string> window = {"--window", GetParam()};
  DenoiseWell(in, folder / "whole", window);
  const std::string part = folder / "part";
  const ProgramRun stopped = InterruptProgram(
      {"denoise", in, "-o", part + "/f.####.exr", "--window", GetParam()}, part + "/f.0004.exr");
  ASSERT_EQ(stopped.exit_code, 130) << stopped.errors;
  EXPECT_TRUE(fs::exists(part + "/resume.stillray"));
  EXPECT_FALSE(fs::exists(part + "/f.0060.exr")) << "it was not interrupted";
  std::vector<std::string> again = window;
  again.push_back("--resume");
  std::vector<std::string> other = again;
  other.insert(other.end(), {"--set", "alpha_min=0.2"});
  const ProgramRun refused = Denoise(in, part, other);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("made with 'alpha_min 0.1', this run has"));
  const ProgramRun resumed = Denoise(in, part, again);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame"));
  EXPECT_THAT(Differences(folder / "whole", part, 1, 60), ::testing::IsEmpty());
  EXPECT_FALSE(fs::exists(part + "/resume.stillray"));
}

// Frames that are in the history and not on disk are in the state: they are not filtered twice.
TEST_P(CliDenoiseResume, APictureThatCannotBeWrittenKeepsTheHistory) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, Shot(), 1, 8);
  DenoiseWell(in, folder / "whole",
              {"--window", GetParam(), "--json", folder / "whole.json", "--threads", "2"});
  for (const auto& [failed, threads] : {std::pair(1, "1"), std::pair(1, "2"), std::pair(5, "1"),
                                        std::pair(5, "2"), std::pair(8, "2")}) {
    const std::string frame = std::to_string(failed);
    const std::string part = folder / ("part" + frame + "." + threads);
    const std::string blocked = part + "/f.000" + frame + ".exr";
    fs::create_directories(blocked + "/in_the_way");
    std::vector<std::string> more = {"--window", GetParam(), "--threads", threads};
    const ProgramRun stopped = Denoise(in, part, more);
    EXPECT_EQ(stopped.exit_code, 2);
    EXPECT_THAT(stopped.errors, HasSubstr(blocked));
    EXPECT_THAT(stopped.errors, HasSubstr("--resume goes on from frame " + frame + "\n"));
    if (failed > 1) {
      EXPECT_THAT(stopped.errors, HasSubstr(std::to_string(failed - 1) + " of 8 frames are"));
    }
    EXPECT_FALSE(fs::exists(part + "/f.000" + std::to_string(failed + 1) + ".exr"));
    fs::remove_all(blocked);
    more.insert(more.end(), {"--resume", "--json", folder / "part.json"});
    const ProgramRun resumed = Denoise(in, part, more);
    ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
    EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame " + frame));
    EXPECT_THAT(Differences(folder / "whole", part, 1, 8), ::testing::IsEmpty());
    EXPECT_FALSE(fs::exists(part + "/resume.stillray"));
    // Reports of frames survive, too.
    const auto whole = nlohmann::json::parse(ReadText(folder / "whole.json"))["frames"];
    const auto parts = nlohmann::json::parse(ReadText(folder / "part.json"))["frames"];
    ASSERT_EQ(parts.size(), 8u);
    for (size_t i = 0; i < 8; ++i) {
      EXPECT_EQ(parts[i]["frame"], whole[i]["frame"]);
      EXPECT_EQ(parts[i]["without_history"], whole[i]["without_history"]) << i;
    }
  }
}

// The picture of the state comes from the input of then.
TEST_P(CliDenoiseResume, AnInputOfAnUnwrittenFrameMustNotChange) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, Shot(), 1, 4);
  const std::string part = folder / "part";
  fs::create_directories(part + "/f.0002.exr/in_the_way");
  EXPECT_EQ(Denoise(in, part, {"--window", GetParam()}).exit_code, 2);
  fs::remove_all(part + "/f.0002.exr");
  Shot other;
  other.contrast = 0.3f;
  WriteShot(in, other, 2, 2);
  const ProgramRun refused = Denoise(in, part, {"--window", GetParam(), "--resume"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("in.0002.exr has changed since"));
}

TEST_P(CliDenoiseResume, ATruncatedFrameStopsTheRunUntilItIsRepaired) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, Shot(), 1, 36);
  const std::vector<std::string> window = {"--window", GetParam()};
  DenoiseWell(in, folder / "whole", window);
  const std::string bytes = ReadText(folder / "in.0034.exr");
  ASSERT_TRUE(WriteFileAtomically(folder / "in.0034.exr", bytes.data(), bytes.size() / 2).ok());
  const ProgramRun stopped = Denoise(in, folder / "part", window);
  EXPECT_EQ(stopped.exit_code, 2);
  EXPECT_THAT(stopped.errors, HasSubstr("in.0034.exr"));
  EXPECT_THAT(stopped.errors, HasSubstr("frames are finished, --resume goes on from frame"));
  EXPECT_TRUE(fs::exists(folder / "part/f.0016.exr"));
  EXPECT_FALSE(fs::exists(folder / "part/f.0034.exr"));
  ASSERT_TRUE(WriteFileAtomically(folder / "in.0034.exr", bytes.data(), bytes.size()).ok());
  std::vector<std::string> again = window;
  again.push_back("--resume");
  DenoiseWell(in, folder / "part", again);
  EXPECT_THAT(Differences(folder / "whole", folder / "part", 1, 36), ::testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Windows, CliDenoiseResume, ::testing::Values("past", "both"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace stillray::cli_denoise_window_test
