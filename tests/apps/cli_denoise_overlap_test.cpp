// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise reads the next file and writes the last one while it filters: its files and
// messages must not depend on that.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_overlap_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// Enough for the overlap on machines with a single processor too.
const std::vector<std::string> kThreads = {"--threads", "3"};

std::vector<std::string> Arguments(const std::string& in, const std::string& out,
                                   const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"denoise", in, "-o", out + "/f.####.exr"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// Name and content of all files of a folder.
std::set<std::pair<std::string, std::string>> FilesIn(const std::string& folder) {
  std::set<std::pair<std::string, std::string>> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    files.emplace(entry.path().filename().string(), ReadText(entry.path().string()));
  }
  return files;
}

/// The frames first..last of a folder, as FilesIn() lists them.
std::set<std::pair<std::string, std::string>> Frames(const std::string& folder, int first,
                                                     int last) {
  std::set<std::pair<std::string, std::string>> files;
  for (int frame = first; frame <= last; ++frame) {
    const std::string name = FrameFileName("f.####.exr", frame);
    files.emplace(name, ReadText(folder + "/" + name));
  }
  return files;
}

/// Byte for byte the same, without the bytes in the message.
void ExpectSame(const std::set<std::pair<std::string, std::string>>& a,
                const std::set<std::pair<std::string, std::string>>& b) {
  std::vector<std::string> names_a;
  std::vector<std::string> names_b;
  for (const auto& [name, bytes] : a) {
    names_a.push_back(name);
  }
  for (const auto& [name, bytes] : b) {
    names_b.push_back(name);
  }
  EXPECT_EQ(names_a, names_b);
  EXPECT_TRUE(a == b);
}

class CliDenoiseOverlap : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { in_ = folder_ / "in.####.exr"; }

  ProgramRun Denoise(const std::string& out, std::vector<std::string> more) {
    more.insert(more.end(), {"--window", GetParam()});
    return RunProgram(Arguments(in_, out, more));
  }
  /// One thread does one thing after the other.
  std::string OneByOne() {
    const std::string out = folder_ / "one_by_one";
    const ProgramRun run = Denoise(out, {"--threads", "1"});
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return out;
  }

  TemporaryFolder folder_;
  std::string in_;
};

TEST_P(CliDenoiseOverlap, ChangesNoBits) {
  WriteShot(in_, Shot(), 1, 20);
  const std::string expected = OneByOne();
  const std::string out = folder_ / "out";
  const ProgramRun run = Denoise(out, kThreads);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, Not(HasSubstr("note: files are not read and written beside")));
  ExpectSame(FilesIn(out), FilesIn(expected));
}

// The other memory of the overlap must not lead to rejection of a frame.
TEST_P(CliDenoiseOverlap, GivesWayWhereMemoryIsShort) {
  WriteShot(in_, Shot(), 1, 3);
  const std::string expected = OneByOne();
  const ProgramRun refused = Denoise(folder_ / "none", {"--memory-limit", "0.5M"});
  const std::string marker = "takes about ";
  const size_t at = refused.errors.find(marker);
  ASSERT_NE(at, std::string::npos) << refused.errors;
  const double megabytes = std::stod(refused.errors.substr(at + marker.size()));
  std::vector<std::string> limited = kThreads;
  limited.insert(limited.end(), {"--memory-limit", std::to_string(megabytes + 0.1) + "M"});
  const ProgramRun run = Denoise(folder_ / "out", limited);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("note: files are not read and written beside the filter: that "
                                    "would take about "));
  ExpectSame(FilesIn(folder_ / "out"), FilesIn(expected));
}

TEST_P(CliDenoiseOverlap, MessagesComeInTheOrderOfFrames) {
  Shot other;
  other.depth = 9;
  other.normal_axis = 0;
  WriteShot(in_, Shot(), 1, 3);
  WriteShot(in_, other, 4, 5);  // a cut
  WriteShot(in_, other, 8, 9);  // a gap
  const ProgramRun run = Denoise(folder_ / "out", kThreads);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  size_t last = 0;
  for (const char* line :
       {"frame 1 (1 of 7): read ", "frame 2 (2 of 7)", "frame 3 (3 of 7)",
        "note: frame 4: hardly anything of the frame before is found again", "frame 4 (4 of 7)",
        "frame 5 (5 of 7)", "note: frame 8: frames after 5 are missing; the history starts again",
        "frame 8 (6 of 7)", "frame 9 (7 of 7)"}) {
    const size_t at = run.errors.find(line);
    ASSERT_NE(at, std::string::npos) << line << "\n" << run.errors;
    EXPECT_GE(at, last) << line << "\n" << run.errors;
    last = at;
  }
}

// Frame 4 is being read when frame 3 turns out to be damaged, and frame 2 is being written.
TEST_P(CliDenoiseOverlap, ADamagedFrameIsNamedWhenItsTurnComes) {
  WriteShot(in_, Shot(), 1, 5);
  const std::string expected = OneByOne();
  const std::string bytes = ReadText(folder_ / "in.0003.exr");
  ASSERT_TRUE(WriteFileAtomically(folder_ / "in.0003.exr", bytes.data(), bytes.size() / 2).ok());
  const std::string out = folder_ / "out";
  const ProgramRun run = Denoise(out, kThreads);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("in.0003.exr: is a damaged EXR file"));
  if (std::string(GetParam()) == "both") {
    // The future of the first frame is needed before anything is written.
    EXPECT_TRUE(FilesIn(out).empty());
    return;
  }
  EXPECT_THAT(run.errors, HasSubstr("frame 2 (2 of 5)"));
  EXPECT_THAT(run.errors,
              HasSubstr("; 2 of 5 frames are finished, --resume goes on from frame 3\n"));
  fs::remove(out + "/resume.stillray");
  ExpectSame(FilesIn(out), Frames(expected, 1, 2));
}

TEST_P(CliDenoiseOverlap, AFullDiskLeavesWholeFramesOnly) {
  Shot quiet;
  quiet.noisy = false;
  quiet.contrast = 0;
  WriteShot(in_, quiet, 1, 3);
  WriteShot(in_, Shot(), 4, 7);
  const std::string expected = OneByOne();
  // A limit on the size of files, in blocks of 512 bytes, stands for the full disk: frames of noise
  // do not fit.
  const uintmax_t small = fs::file_size(expected + "/f.0003.exr");
  const uintmax_t large = fs::file_size(expected + "/f.0004.exr");
  ASSERT_GT(large, small + 2048);
  const std::string out = folder_ / "out";
  const std::string command = "ulimit -f " + std::to_string((small + large) / 2 / 512) + "; '" +
                              STILLRAY_PROGRAM + "' denoise '" + in_ + "' -o '" + out +
                              "/f.####.exr' --threads 3 --window " + GetParam() +
                              " >/dev/null 2>'" + (folder_ / "errors") + "'";
  const int state = std::system(command.c_str());
  EXPECT_TRUE(WIFEXITED(state) && WEXITSTATUS(state) == 2);
  const std::string errors = ReadText(folder_ / "errors");
  EXPECT_THAT(errors,
              HasSubstr("f.0004.exr: could not be written: File too large; 3 of 7 frames "
                        "are finished; the state for --resume could not be saved either\n"));
  ExpectSame(FilesIn(out), Frames(expected, 1, 3));
}

TEST_P(CliDenoiseOverlap, AnInterruptLeavesWholeFramesAndSaysHowMany) {
  WriteShot(in_, Shot(), 1, 60);
  const std::string out = folder_ / "out";
  std::vector<std::string> more = kThreads;
  more.insert(more.end(), {"--window", GetParam()});
  const ProgramRun stopped = InterruptProgram(Arguments(in_, out, more), out + "/f.0004.exr");
  ASSERT_EQ(stopped.exit_code, 130) << stopped.errors;
  const std::string marker = "error: stopped; ";
  const size_t at = stopped.errors.find(marker);
  ASSERT_NE(at, std::string::npos) << stopped.errors;
  const int done = std::stoi(stopped.errors.substr(at + marker.size()));
  EXPECT_GE(done, 4);
  ASSERT_LT(done, 60) << "it was not interrupted";
  EXPECT_THAT(stopped.errors, HasSubstr(std::to_string(done) +
                                        " of 60 frames are finished, "
                                        "--resume goes on from frame " +
                                        std::to_string(done + 1) + "\n"));
  ASSERT_TRUE(fs::remove(out + "/resume.stillray"));
  ExpectSame(FilesIn(out), Frames(OneByOne(), 1, done));
}

TEST_P(CliDenoiseOverlap, TellsTheSlowestPart) {
  WriteShot(in_, Shot(), 1, 4);
  std::vector<std::string> more = kThreads;
  more.insert(more.end(), {"--timings", "--json", folder_ / "log.json"});
  const ProgramRun run = Denoise(folder_ / "out", more);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("\n  frame to frame "));
  const auto json = nlohmann::json::parse(ReadText(folder_ / "log.json"));
  double read = 0;
  double denoise = 0;
  double write = 0;
  for (const auto& frame : json["frames"]) {
    read += frame["read_ms"].get<double>();
    denoise += frame["future_ms"].get<double>() + frame["denoise_ms"].get<double>();
    write += frame["write_ms"].get<double>();
    EXPECT_GT(frame["elapsed_ms"].get<double>(), 0);
  }
  const double most = std::max({read, denoise, write});
  const std::string slowest = most == read ? "read" : most == denoise ? "denoise" : "write";
  EXPECT_EQ(json["slowest_part"], slowest);
  EXPECT_THAT(run.output, HasSubstr("\n  slowest part: " + slowest + " (at work: read "));
}

INSTANTIATE_TEST_SUITE_P(Windows, CliDenoiseOverlap, ::testing::Values("past", "both"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace stillray::cli_denoise_overlap_test
