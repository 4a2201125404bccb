// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Outputs of stillray denoise besides its files: previews, findings of the doctor, the last line;
// and names of folders and sequences.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_output_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class CliDenoiseOutput : public ::testing::Test {
 protected:
  std::string In() const { return folder_ / "in.####.exr"; }
  std::string Out() const { return folder_ / "clean/in.####.exr"; }

  /// Denoises In() into Out().
  ProgramRun Denoise(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"denoise", In(), "-o", Out()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  /// Frames with a NaN in the normals of every other one.
  void WriteSpoiled(int64_t first, int64_t last) const {
    for (int64_t frame = first; frame <= last; ++frame) {
      ExrImage image = ShotFrame(Shot(), frame);
      for (Channel& channel : image.channels) {
        if (channel.name == "ViewLayer.Normal.X" && frame % 2 == 0) {
          channel.values(5, 5) = std::nanf("");
        }
      }
      ASSERT_TRUE(WriteExr(FrameFileName(In(), frame), image).ok());
    }
  }

  /// Leaves half of a file.
  static void CutFile(const std::string& path) {
    const std::string bytes = ReadText(path);
    ASSERT_TRUE(WriteFileAtomically(path, bytes.data(), bytes.size() / 2).ok());
  }

  TemporaryFolder folder_;
};

size_t CountOf(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

TEST_F(CliDenoiseOutput, EndsWithWhatWasWritten) {
  WriteShot(In(), Shot(), 1, 3);
  const ProgramRun run = Denoise();
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output,
              ::testing::ContainsRegex("wrote 3 frames to .*/clean/ \\([0-9.]+ kB\\) in "
                                       "[0-9.]+ s, [0-9.]+ ms per frame\n$"));
}

TEST_F(CliDenoiseOutput, FolderWithoutASlash) {
  WriteShot(In(), Shot(), 1, 2);
  const ProgramRun run = RunProgram({"denoise", In(), "-o", folder_ / "new/clean"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_TRUE(fs::exists(folder_ / "new/clean/in.0002.exr"));
  const ProgramRun wrong = RunProgram({"denoise", In(), "-o", folder_ / "a.####.png"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("--preview"));
}

TEST_F(CliDenoiseOutput, WildCards) {
  WriteShot(In(), Shot(), 1, 2);
  for (const char* name : {"in.*.exr", "in.##.exr", "in.????.exr", "in.%d.exr"}) {
    const ProgramRun run =
        RunProgram({"denoise", folder_ / name, "-o", folder_ / "wild/out.*.exr", "--no-check"});
    ASSERT_EQ(run.exit_code, 0) << name << run.errors;
    EXPECT_TRUE(fs::exists(folder_ / "wild/out.0002.exr")) << name;
    fs::remove_all(folder_ / "wild");
  }
  const ProgramRun wrong = RunProgram({"denoise", folder_ / "im.####.exr", "-o", Out()});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("found in.0001.exr ... in.0002.exr: did you mean"));
}

TEST_F(CliDenoiseOutput, BothSidesAreTheDefaultOfAWholeSequence) {
  WriteShot(In(), Shot(), 1, 6);
  const auto window = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = more;
    all.insert(all.end(), {"--json", folder_ / "log.json"});
    const ProgramRun run = Denoise(all);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return nlohmann::json::parse(ReadText(folder_ / "log.json"))["window"].get<std::string>() +
           (run.errors.find("note: --window past") != std::string::npos ? ", said" : "");
  };
  EXPECT_EQ(window({}), "both");
  EXPECT_EQ(window({"--window", "past"}), "past");
  EXPECT_EQ(window({"--frames", "3"}), "past");
  EXPECT_EQ(window({"--set", "temporal=off"}), "past, said");
  EXPECT_EQ(window({"--memory-limit", "2.5M"}), "past, said");
  fs::remove(folder_ / "in.0003.exr");
  EXPECT_EQ(window({}), "past, said");
  EXPECT_EQ(window({"--window", "both"}), "both");
}

// The frames that are missing may come while the run is interrupted.
TEST_F(CliDenoiseOutput, ResumeKeepsTheWindowOfTheRun) {
  WriteShot(In(), Shot(), 1, 8);
  fs::remove(folder_ / "in.0007.exr");
  CutFile(folder_ / "in.0005.exr");
  const ProgramRun stopped = Denoise();
  ASSERT_EQ(stopped.exit_code, 2);
  EXPECT_THAT(stopped.errors, HasSubstr("--resume goes on"));
  WriteShot(In(), Shot(), 5, 5);
  WriteShot(In(), Shot(), 7, 7);
  const ProgramRun resumed = Denoise({"--resume", "--json", folder_ / "log.json"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_EQ(nlohmann::json::parse(ReadText(folder_ / "log.json"))["window"], "past");
  EXPECT_TRUE(fs::exists(folder_ / "clean/in.0008.exr"));
}

// Finished frames were made without it, and later ones continue their history.
TEST_F(CliDenoiseOutput, AFrameThatCameAmongFinishedOnesIsNamed) {
  WriteShot(In(), Shot(), 1, 8);
  fs::remove(folder_ / "in.0002.exr");
  CutFile(folder_ / "in.0005.exr");
  ASSERT_EQ(Denoise().exit_code, 2);
  WriteShot(In(), Shot(), 5, 5);
  WriteShot(In(), Shot(), 2, 2);
  const ProgramRun resumed = Denoise({"--resume"});
  EXPECT_EQ(resumed.exit_code, 2);
  EXPECT_THAT(resumed.errors, HasSubstr("in.0003.exr was read there before"));
}

TEST_F(CliDenoiseOutput, TellsWhatTheDoctorFinds) {
  WriteSpoiled(1, 4);
  const ProgramRun run = Denoise({"--aov", "depth=none", "--json", folder_ / "log.json"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(CountOf(run.errors, "check: "), 1u) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("check: not_finite: "));
  EXPECT_THAT(run.errors, HasSubstr("; cure: "));
  const auto json = nlohmann::json::parse(ReadText(folder_ / "log.json"));
  ASSERT_EQ(json["findings"].size(), 1u);
  EXPECT_EQ(json["findings"][0]["name"], "not_finite");
  const ProgramRun silent = Denoise({"--no-check"});
  ASSERT_EQ(silent.exit_code, 0);
  EXPECT_THAT(silent.errors, Not(HasSubstr("check: ")));
}

TEST_F(CliDenoiseOutput, CleanInputIsDenoisedWithoutAWord) {
  WriteShot(In(), Shot(), 1, 4);
  // The wall is everywhere at one distance, which is a finding.
  const ProgramRun run = Denoise({"--aov", "depth=none"});
  ASSERT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, Not(HasSubstr("check: ")));
}

TEST_F(CliDenoiseOutput, WarnsOfGuidesThatSayNothingWithoutTheCheckToo) {
  for (int64_t frame = 1; frame <= 2; ++frame) {
    ExrImage image = ShotFrame(Shot(), frame);
    for (Channel& channel : image.channels) {
      if (channel.name.find(".Normal.") != std::string::npos) {
        channel.values.Fill(0);
      }
    }
    ASSERT_TRUE(WriteExr(FrameFileName(In(), frame), image).ok());
  }
  const ProgramRun run = Denoise({"--no-check"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, HasSubstr("warning: frame 1: "));
  EXPECT_THAT(run.errors, HasSubstr("normal"));
}

TEST_F(CliDenoiseOutput, NotesAndFindingsSayNothingTwice) {
  for (int64_t frame = 1; frame <= 3; ++frame) {
    ExrImage image = ShotFrame(Shot(), frame);
    std::erase_if(image.channels, [](const Channel& channel) {
      return channel.name.find(".Vector.") != std::string::npos;
    });
    ASSERT_TRUE(WriteExr(FrameFileName(In(), frame), image).ok());
  }
  const ProgramRun run = Denoise({"--motion", "file"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("check: motion_missing: "));
  EXPECT_THAT(run.output, Not(HasSubstr("no motion: ")));
  const ProgramRun derived = Denoise();
  EXPECT_THAT(derived.errors, Not(HasSubstr("motion_missing")));
  EXPECT_THAT(derived.output, HasSubstr("motion is estimated from the guides"));
  const ProgramRun unchecked = Denoise({"--no-check", "--motion", "file"});
  EXPECT_THAT(unchecked.output, HasSubstr("no motion: "));
  const ProgramRun wanted = Denoise({"--aov", "motion=none"});
  EXPECT_THAT(wanted.errors, Not(HasSubstr("motion_missing")));
  EXPECT_THAT(wanted.output, HasSubstr("no motion: "));
}

TEST_F(CliDenoiseOutput, AFrameOfAnotherSizeIsNamed) {
  WriteShot(In(), Shot(), 1, 2);
  ExrImage other;
  other.width = other.height = 16;
  const ExrImage frame = ShotFrame(Shot(), 3);
  for (const Channel& channel : frame.channels) {
    Image1 part(16, 16);
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) {
        part(x, y) = channel.values(x, y);
      }
    }
    other.Add(channel.name, channel.type, part);
  }
  ASSERT_TRUE(WriteExr(folder_ / "in.0003.exr", other).ok());
  const ProgramRun run = Denoise();
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("note: frame 3: 16 x 16 pixels in place of 48 x 24; the "
                                    "history starts again here"));
  EXPECT_THAT(run.errors, Not(HasSubstr("size_changes")));
}

TEST_F(CliDenoiseOutput, PreviewPictures) {
  WriteShot(In(), Shot(), 1, 2);
  const ProgramRun run = Denoise({"--preview", folder_ / "look/####.png", "--tonemap", "linear"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("preview: " + (folder_ / "look/####.png")));
  const Result<Rgb8Image> plain = ReadPng8(folder_ / "look/0002.png");
  ASSERT_TRUE(plain.ok()) << plain.status().message();
  ASSERT_EQ(plain->width, Shot::kWidth);
  // The wall is 0.5 on average, 188 once it is encoded as sRGB.
  double sum = 0;
  for (const uint8_t value : plain->pixels) {
    sum += value;
  }
  EXPECT_NEAR(sum / static_cast<double>(plain->pixels.size()), 183, 10);
  const ProgramRun brighter =
      Denoise({"--preview", folder_ / "bright", "--tonemap", "linear", "--exposure", "1"});
  ASSERT_EQ(brighter.exit_code, 0) << brighter.errors;
  const Result<Rgb8Image> bright = ReadPng8(folder_ / "bright/in.0002.png");
  ASSERT_TRUE(bright.ok()) << bright.status().message();
  double bright_sum = 0;
  for (const uint8_t value : bright->pixels) {
    bright_sum += value;
  }
  EXPECT_GT(bright_sum, sum * 1.1);
}

TEST_F(CliDenoiseOutput, PreviewMustBeAVideoOrPictures) {
  WriteShot(In(), Shot(), 1, 2);
  const auto error = [&](const std::vector<std::string>& more) {
    const ProgramRun run = Denoise(more);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_FALSE(fs::exists(folder_ / "clean/in.0001.exr"));
    return run.errors;
  };
  EXPECT_THAT(error({"--preview", "a.mov"}), HasSubstr("--preview is 'a.mov', expected a video"));
  EXPECT_THAT(error({"--preview", "one.png"}), HasSubstr("--preview is 'one.png', expected"));
  EXPECT_THAT(error({"--exposure", "1"}), HasSubstr("--exposure is for display pictures"));
  EXPECT_THAT(error({"--preview", "a.mp4", "--fps", "0"}),
              HasSubstr("--fps: found '0', expected 0.001 to 1000"));
}

TEST_F(CliDenoiseOutput, PreviewVideoAlsoAfterAResume) {
  if (std::system("command -v ffmpeg >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "ffmpeg is not installed";
  }
  WriteShot(In(), Shot(), 1, 6);
  const std::string video = folder_ / "look/shot.mp4";
  ASSERT_EQ(Denoise({"--preview", video, "--window", "past"}).exit_code, 0);
  const std::string whole = ReadText(video);
  ASSERT_GT(whole.size(), 1000u);
  fs::remove_all(folder_ / "clean");
  fs::remove(video);
  CutFile(folder_ / "in.0004.exr");
  const ProgramRun stopped = Denoise({"--preview", video, "--window", "past"});
  ASSERT_EQ(stopped.exit_code, 2) << stopped.errors;
  EXPECT_TRUE(fs::is_empty(folder_ / "look")) << "an unfinished video stays";
  WriteShot(In(), Shot(), 4, 4);
  const ProgramRun resumed = Denoise({"--preview", video, "--window", "past", "--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  // The files hold floats, so that the frames of before are the same to the last bit.
  EXPECT_EQ(ReadText(video), whole);
  EXPECT_THAT(resumed.output, HasSubstr("wrote 3 frames to"));
  EXPECT_THAT(resumed.output, HasSubstr("; 3 frames were there already"));
}

TEST_F(CliDenoiseOutput, JsonThatCannotBeWrittenIsFoundFirst) {
  WriteShot(In(), Shot(), 1, 2);
  for (const std::string& path : {folder_ / "none/log.json", folder_.path()}) {
    const ProgramRun run = Denoise({"--json", path});
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr("--json " + path));
    EXPECT_FALSE(fs::exists(folder_ / "clean/in.0001.exr"));
    const ProgramRun render = RunProgram({"render", "builtin:cornell", "-o", folder_ / "render",
                                          "--size", "16x9", "--frames", "1", "--json", path});
    EXPECT_EQ(render.exit_code, 2);
    EXPECT_THAT(render.errors, HasSubstr("--json " + path));
    EXPECT_FALSE(fs::exists(folder_ / "render/render.json"));
  }
  // The folder of the output is made first.
  EXPECT_EQ(Denoise({"--json", folder_ / "clean/log.json"}).exit_code, 0);
}

}  // namespace
}  // namespace stillray::cli_denoise_output_test
