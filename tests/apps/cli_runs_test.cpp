// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What happens to runs of stillray around their frames: names, streams and disks that are not as
// they should be.
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "../scene/gltf_builder.h"
#include "cli_denoise_shot.h"
#include "program.h"
#include "stillray/io.h"

namespace stillray {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> Render(const std::string& folder, std::vector<std::string> more,
                                const std::string& scene = "builtin:cornell") {
  std::vector<std::string> all = {"render",   scene,   "-o",       folder,      "--size",
                                  "32x18",    "--fps", "15",       "--bounces", "1",
                                  "--format", "exr",   "--frames", "1-3"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// A scene in a file: one triangle.
void WriteTriangle(const std::string& path) {
  test::GltfBuilder builder;
  builder.AddTriangle();
  const std::string text = builder.Text();
  const Status written = WriteFileAtomically(path, text.data(), text.size());
  ASSERT_TRUE(written.ok()) << written.message();
}

/// The exit code of a shell command that names the program as $0.
int Shell(const std::string& command) {
  const std::string all = "sh -c '" + command + "' '" + STILLRAY_PROGRAM + "'";
  const int state = std::system(all.c_str());
  return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

TEST(CliRuns, ASceneWhoseNameIsNotUtf8KeepsItsLog) {
  const TemporaryFolder folder;
  const std::string scene = folder / "alt\xff.gltf";
  WriteTriangle(scene);
  const ProgramRun run = RunProgram(Render(folder / "out", {}, scene));
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const auto json = nlohmann::json::parse(ReadText(folder / "out" + "/render.json"));
  EXPECT_EQ(json["frames"].size(), 3u);
  EXPECT_THAT(json["scene"].get<std::string>(), HasSubstr("alt\xef\xbf\xbd.gltf"));
  const ProgramRun again = RunProgram(Render(folder / "out", {"--resume"}, scene));
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_THAT(again.errors, HasSubstr("all frames are there already"));
  const ProgramRun bench =
      RunProgram({"bench", "--scene", scene, "--fps", "--size", "32x18", "--warm-up", "0",
                  "--repeats", "1", "--device", "cpu", "--json", folder / "bench.json"});
  EXPECT_EQ(bench.exit_code, 0) << bench.errors;
  EXPECT_TRUE(nlohmann::json::accept(ReadText(folder / "bench.json")));
}

TEST(CliRuns, ProgressThatCannotBeWrittenDoesNotMatter) {
  const TemporaryFolder folder;
  const ProgramRun full = RunProgram(Render(folder / "full", {}), "", "/dev/full");
  EXPECT_EQ(full.exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "full" + "/denoised.0003.exr"));
  EXPECT_TRUE(fs::exists(folder / "full" + "/render.json"));
  WriteShot(folder / "in.####.exr", Shot(), 1, 3);
  const ProgramRun denoised = RunProgram(
      {"denoise", folder / "in.####.exr", "-o", folder / "clean.####.exr"}, "", "/dev/full");
  EXPECT_EQ(denoised.exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "clean.0003.exr"));
}

// A file of the run must not get the number of a standard stream: messages would go into it.
TEST(CliRuns, ClosedStreamsChangeNoFile) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunProgram(Render(folder / "open", {})).exit_code, 0);
  EXPECT_EQ(Shell("\"$0\" render builtin:cornell -o " + (folder / "closed") +
                  " --size 32x18 --fps 15 --bounces 1 --format exr --frames 1-3 <&- >&- 2>&-"),
            0);
  for (const char* name : {"noisy.0001.exr", "denoised.0003.exr"}) {
    EXPECT_EQ(ReadText(folder / "open/" + name), ReadText(folder / "closed/" + name)) << name;
  }
}

TEST(CliRuns, OutputThatIsLostIsAFailure) {
  const TemporaryFolder folder;
  WriteShot(folder / "in.####.exr", Shot(), 1, 2);
  ASSERT_EQ(RunProgram(Render(folder / "out", {})).exit_code, 0);
  const std::vector<std::string> commands[] = {
      {"check", folder / "in.####.exr"},
      {"denoise", folder / "in.####.exr", "-o", folder / "clean.####.exr"},
      {"report", folder / "out"},
      {"info", folder / "in.0001.exr"},
      Render(folder / "again", {"--timings"}),
  };
  for (const std::vector<std::string>& command : commands) {
    const ProgramRun run = RunProgram(command, "/dev/full");
    EXPECT_EQ(run.exit_code, 2) << command[0];
    EXPECT_THAT(run.errors, HasSubstr("standard output: could not be written: No space left"))
        << command[0];
  }
}

}  // namespace
}  // namespace stillray
