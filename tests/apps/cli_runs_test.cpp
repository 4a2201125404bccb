// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Runs of stillray with unusual names, streams and disks.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "../scene/gltf_builder.h"
#include "cli_denoise_shot.h"
#include "program.h"
#include "stillray/io.h"

namespace stillray::cli_runs_test {
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

TEST(CliRuns, NamesWithSpacesUmlautsAndQuotes) {
  const TemporaryFolder folder;
  const std::string out = folder / "it's \"\xc3\xbc\" [1] # %d";
  const std::string clean = folder / "cl'\xc3\xa4 n";
  const std::string scene = folder / "my \"sc\xc3\xb6n'e\".gltf";
  WriteTriangle(scene);
  const ProgramRun rendered =
      RunProgram(Render(out, {"--frames", "1-2", "--save-inputs", "--reference", "1"}, scene));
  ASSERT_EQ(rendered.exit_code, 0) << rendered.errors;
  EXPECT_THAT(rendered.output, HasSubstr("wrote 2 frames to " + out + "/ ("));
  const ProgramRun denoised = RunProgram({"denoise", out + "/noisy.####.exr", "-o", clean,
                                          "--preview", clean + "/l\xc3\xb6'ok/####.png"});
  ASSERT_EQ(denoised.exit_code, 0) << denoised.errors;
  EXPECT_TRUE(fs::exists(clean + "/noisy.0002.exr"));
  EXPECT_TRUE(fs::exists(clean + "/l\xc3\xb6'ok/0002.png"));
  const ProgramRun compared =
      RunProgram({"compare", clean + "/noisy.####.exr", out + "/reference.####.exr"});
  EXPECT_EQ(compared.exit_code, 0) << compared.errors;
  const ProgramRun reported = RunProgram({"report", out});
  EXPECT_EQ(reported.exit_code, 0) << reported.errors;
  EXPECT_TRUE(fs::exists(out + "/report.html"));
}

// The test holds the lock that a run holds on its folder.
TEST(CliRuns, AnotherRunInTheFolderIsNoticed) {
  const TemporaryFolder folder;
  const std::string warning = "another run is writing to " + folder.path();
  EXPECT_THAT(RunProgram(Render(folder.path(), {"--frames", "1"})).errors, Not(HasSubstr(warning)));
  const int other = ::open(folder.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(other, LOCK_EX), 0);
  const ProgramRun second = RunProgram(Render(folder.path(), {"--frames", "1"}));
  EXPECT_EQ(second.exit_code, 0);
  EXPECT_THAT(second.errors, HasSubstr(warning));
  ::close(other);
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
  for (const char* name : {"denoised.0001.exr", "denoised.0003.exr"}) {
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

/// Starts a run of frames 1-5 that ends at frame 3, whose file cannot be written.
void StopAtThird(const std::string& folder, const std::string& scene = "builtin:cornell",
                 const std::string& threads = "2") {
  fs::create_directories(folder + "/denoised.0003.exr/in_the_way");
  const ProgramRun run =
      RunProgram(Render(folder, {"--frames", "1-5", "--threads", threads}, scene));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("denoised.0003.exr: could not be written"));
  EXPECT_THAT(run.errors, HasSubstr("; 2 of 5 frames are finished, --resume goes on from here"));
  fs::remove_all(folder + "/denoised.0003.exr");
}

void ExpectSamePictures(const std::string& a, const std::string& b) {
  for (const std::string& name : FilesIn(a)) {
    if (fs::path(name).extension() == ".exr") {
      EXPECT_EQ(ReadText(a + "/" + name), ReadText(b + "/" + name)) << name;
    }
  }
}

// A frame that was filtered and could not be written is in the history already: it must come out
// the same when the run goes on.
TEST(CliRuns, APictureThatCannotBeWrittenKeepsTheHistory) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunProgram(Render(folder / "whole", {"--frames", "1-5"})).exit_code, 0);
  for (const char* threads : {"1", "2"}) {
    const std::string out = folder / threads;
    StopAtThird(out, "builtin:cornell", threads);
    const ProgramRun resumed = RunProgram(Render(out, {"--frames", "1-5", "--resume"}));
    EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
    EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame 3"));
    ExpectSamePictures(folder / "whole", out);
    const auto json = nlohmann::json::parse(ReadText(out + "/render.json"));
    EXPECT_EQ(json["frames"].size(), 5u);
  }
}

TEST(CliRuns, AnotherSceneOfTheSameNameIsNotResumed) {
  const TemporaryFolder folder;
  const std::string scene = folder / "scene.gltf";
  WriteTriangle(scene);
  StopAtThird(folder / "out", scene);
  // Content counts, not the place.
  fs::create_directory(folder / "elsewhere");
  fs::copy_file(scene, folder / "elsewhere/scene.gltf");
  fs::copy(folder / "out", folder / "copy");
  const ProgramRun moved = RunProgram(
      Render(folder / "copy", {"--frames", "1-5", "--resume"}, folder / "elsewhere/scene.gltf"));
  EXPECT_EQ(moved.exit_code, 0) << moved.errors;
  test::GltfBuilder builder;
  builder.AddTriangle();
  builder.json["nodes"][0]["scale"] = {2, 1, 1};
  const std::string text = builder.Text();
  ASSERT_TRUE(WriteFileAtomically(scene, text.data(), text.size()).ok());
  const ProgramRun other =
      RunProgram(Render(folder / "out", {"--frames", "1-5", "--resume"}, scene));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr("made with 'scene scene.gltf with content "));
}

TEST(CliRuns, FinishedFramesThatAreGoneAreRenderedAgain) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  ASSERT_EQ(RunProgram(Render(out, {})).exit_code, 0);
  const std::string frame = out + "/denoised.0002.exr";
  const std::string bytes = ReadText(frame);
  std::string zeros = bytes;
  std::fill(zeros.begin() + static_cast<std::ptrdiff_t>(zeros.size() / 2), zeros.end(), '\0');
  const std::pair<std::string, const char*> damages[] = {
      {"", "is empty"}, {bytes.substr(0, 900), "has changed"}, {zeros, "has changed"}};
  for (const auto& [damage, message] : damages) {
    ASSERT_TRUE(WriteFileAtomically(frame, damage.data(), damage.size()).ok());
    const ProgramRun again = RunProgram(Render(out, {"--resume"}));
    EXPECT_EQ(again.exit_code, 0) << again.errors;
    EXPECT_THAT(again.errors, HasSubstr("starting again with frame 1: " + frame + " " + message));
    EXPECT_EQ(ReadText(frame), bytes);
  }
  fs::remove(frame);
  EXPECT_THAT(RunProgram(Render(out, {"--resume"})).errors, HasSubstr("0002.exr is missing"));
  EXPECT_EQ(ReadText(frame), bytes);
  EXPECT_THAT(RunProgram(Render(out, {"--resume"})).errors, HasSubstr("all frames are there"));
}

TEST(CliRuns, ADamagedStateIsRefused) {
  const TemporaryFolder folder;
  StopAtThird(folder / "out");
  const std::string path = folder / "out/resume.stillray";
  const std::string bytes = ReadText(path);
  for (const double part : {0.002, 0.1, 0.5, 0.99}) {
    std::string damaged = bytes;
    damaged[static_cast<size_t>(part * static_cast<double>(bytes.size()))] ^= 1;
    ASSERT_TRUE(WriteFileAtomically(path, damaged.data(), damaged.size()).ok());
    const ProgramRun run = RunProgram(Render(folder / "out", {"--frames", "1-5", "--resume"}));
    EXPECT_EQ(run.exit_code, 2) << part;
    EXPECT_THAT(run.errors, HasSubstr("resume.stillray is damaged")) << part;
  }
}

TEST(CliRuns, TwoRunsInOneFolderKeepTheirStates) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  ASSERT_EQ(RunProgram(Render(folder / "whole", {"--frames", "1-5"})).exit_code, 0);
  StopAtThird(out);
  ASSERT_EQ(RunProgram(Render(out, {"--frames", "11-12"})).exit_code, 0);
  const ProgramRun resumed = RunProgram(Render(out, {"--frames", "1-5", "--resume"}));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame 3"));
  ExpectSamePictures(folder / "whole", out);
  const auto json = nlohmann::json::parse(ReadText(out + "/render.json"));
  std::vector<int> numbers;
  for (const auto& frame : json["frames"]) {
    numbers.push_back(frame["frame"]);
  }
  EXPECT_THAT(numbers, ::testing::ElementsAre(1, 2, 3, 4, 5, 11, 12));
  EXPECT_THAT(RunProgram(Render(out, {"--frames", "11-12", "--resume"})).errors,
              HasSubstr("all frames are there already"));
  // Also where the state before it is gone.
  fs::remove(out + "/resume.stillray");
  EXPECT_THAT(RunProgram(Render(out, {"--frames", "11-12", "--resume"})).errors,
              HasSubstr("all frames are there already"));
  // Frames of other settings are not listed as if they were of these.
  ASSERT_EQ(RunProgram(Render(out, {"--frames", "21-21", "--seed", "3"})).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(ReadText(out + "/render.json"))["frames"].size(), 1u);
}

TEST(CliRuns, DenoiseResumesWithTheInputsOfThenOnly) {
  const TemporaryFolder folder;
  WriteShot(folder / "in.####.exr", Shot(), 1, 5);
  const std::vector<std::string> command = {
      "denoise", folder / "in.####.exr", "-o", folder / "out/c.####.exr", "--window", "past"};
  ASSERT_EQ(RunProgram(command).exit_code, 0);
  const std::string third = ReadText(folder / "out/c.0003.exr");
  const std::string second = ReadText(folder / "out/c.0002.exr");
  const std::string fourth = ReadText(folder / "in.0004.exr");
  // An input that cannot be read: the state is kept.
  std::ofstream(folder / "in.0004.exr", std::ios::trunc) << "damaged";
  const ProgramRun stopped = RunProgram(command);
  ASSERT_EQ(stopped.exit_code, 2);
  ASSERT_THAT(stopped.errors, HasSubstr("--resume goes on from frame 4"));
  std::ofstream(folder / "in.0004.exr", std::ios::trunc | std::ios::binary) << fourth;
  std::vector<std::string> resume = command;
  resume.push_back("--resume");

  const std::string input = ReadText(folder / "in.0002.exr");
  Shot other;
  other.contrast = 0.3f;
  WriteShot(folder / "in.####.exr", other, 2, 2);
  const ProgramRun refused = RunProgram(resume);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("in.0002.exr has changed since"));
  std::ofstream(folder / "in.0002.exr", std::ios::trunc | std::ios::binary) << input;

  fs::remove(folder / "out/c.0002.exr");
  const ProgramRun again = RunProgram(resume);
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_THAT(again.errors, HasSubstr("starting again with frame 1: "));
  EXPECT_EQ(ReadText(folder / "out/c.0002.exr"), second);
  EXPECT_EQ(ReadText(folder / "out/c.0003.exr"), third);
}

TEST(CliRuns, AKilledRunLeavesNoVideoForGood) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "ffmpeg is not installed";
  }
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  {
    const StartedProgram program(
        Render(out, {"--frames", "1-2000", "--format", "png,mp4", "--size", "160x90"}));
    for (int i = 0; i < 30000 && !fs::exists(out + "/denoised.0001.png"); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    program.Signal(SIGKILL);
    EXPECT_EQ(program.Wait().exit_code, -1);
  }
  const auto temporaries = [&] {
    std::vector<std::string> found;
    for (const std::string& name : FilesIn(out)) {
      if (name.find(".tmp-") != std::string::npos) {
        found.push_back(name);
      }
    }
    return found;
  };
  ASSERT_FALSE(temporaries().empty()) << "it was killed before it began a video";
  ASSERT_EQ(RunProgram(Render(out, {"--frames", "1-1"})).exit_code, 0);
  EXPECT_THAT(temporaries(), ::testing::IsEmpty());
}

/// The long options in a command's help, without "no-".
std::set<std::string> OptionsOf(const std::string& command) {
  std::istringstream help(RunProgram({command, "--help"}).output);
  std::set<std::string> names;
  for (std::string line; std::getline(help, line);) {
    if (!line.starts_with("  -")) {
      continue;
    }
    std::istringstream list(line.substr(2, line.find_first_of(" {=", 2) - 2));
    for (std::string name; std::getline(list, name, ',');) {
      if (name.starts_with("--")) {
        names.insert(name.substr(name.starts_with("--no-") ? 5 : 2));
      }
    }
  }
  return names;
}

/// What an option changes in render.json.
struct LoggedOption {
  const char* key;
  std::vector<std::string> arguments;  ///< another value than that of Render()
};

// An option without a row fails: whoever adds one says which key has it, or that pictures are the
// same with it.
TEST(CliRuns, TheLogHasEveryOptionThatChangesThePictures) {
  const TemporaryFolder folder;
  Image3 sky(4, 2);
  for (int c = 0; c < 3; ++c) {
    sky[c].Fill(0.5f);
  }
  ExrImage map;
  map.width = 4;
  map.height = 2;
  map.Add("", PixelType::kFloat, sky);
  ASSERT_TRUE(WriteExr(folder / "sky.exr", map).ok());
  Rgb8Image mask;
  mask.width = mask.height = 2;
  mask.pixels.assign(12, 255);
  ASSERT_TRUE(WritePng(folder / "mask.png", mask).ok());
  std::ofstream(folder / "look.txt") << "sigma_l=7\n";

  const std::set<std::string> same_pictures = {"help", "output",  "resume", "timings",
                                               "json", "threads", "verbose"};
  const std::multimap<std::string, LoggedOption> logged = {
      {"size", {"width", {"--size", "30x18"}}},
      {"size", {"height", {"--size", "32x20"}}},
      {"exposure", {"exposure", {"--exposure", "1"}}},
      {"tonemap", {"tonemap", {"--tonemap", "filmic"}}},
      {"aov", {"aov", {"--aov", "temporal"}}},
      {"format", {"format", {"--format", "exr,png"}}},
      {"save-inputs", {"save_inputs", {"--save-inputs"}}},
      {"float", {"float", {"--float"}}},
      {"frames", {"frames", {"--frames", "2"}}},
      {"fps", {"fps", {"--fps", "25"}}},
      {"still", {"still", {"--still"}}},
      {"camera", {"camera", {"--camera", "0"}}},
      {"environment", {"environment", {"--environment", folder / "sky.exr"}}},
      {"environment", {"environment_content", {"--environment", folder / "sky.exr"}}},
      {"lens-mask", {"lens_mask", {"--lens-mask", folder / "mask.png"}}},
      {"lens-mask", {"lens_mask_content", {"--lens-mask", folder / "mask.png"}}},
      {"reference", {"reference", {"--reference", "2"}}},
      {"reference-frames", {"reference_frames", {"--reference", "2", "--reference-frames", "1"}}},
      {"preset", {"preset", {"--preset", "svgf"}}},
      {"preset", {"parameters", {"--preset", "svgf"}}},
      {"settings", {"parameters", {"--settings", folder / "look.txt"}}},
      {"set", {"parameters", {"--set", "sigma_l=7"}}},
      {"device", {"device", {}}},
      {"device", {"tracer", {}}},
      {"trace-device", {"tracer", {}}},
      {"ray-tracing", {"ray_tracing", {"--ray-tracing", "compute"}}},
      {"first-hits", {"first_hits", {"--first-hits", "trace"}}},
      {"textures", {"textures", {"--textures", "exact"}}},
      {"spp", {"spp", {"--spp", "2"}}},
      {"guides", {"guides", {"--spp", "1/2", "--guides", "sparse"}}},
      {"seed", {"seed", {"--seed", "4"}}},
      {"sampler", {"sampler", {"--sampler", "halton16"}}},
      {"jitter", {"jitter", {"--no-jitter"}}},
      {"filter-textures", {"filter_textures", {"--no-filter-textures"}}},
      {"virtual-guides", {"virtual_guides", {"--no-virtual-guides"}}},
      {"bounces", {"bounces", {"--bounces", "2"}}},
      {"regularise", {"regularise", {"--regularise"}}},
      {"light-sampling", {"light_sampling", {"--light-sampling", "light"}}},
      {"light-candidates", {"light_candidates", {"--light-candidates", "2"}}},
      {"clamp-radiance", {"clamp_radiance", {"--clamp-radiance", "1"}}},
      {"aperture", {"aperture", {"--aperture", "0.1"}}},
      {"focus", {"focus", {"--focus", "2"}}},
      {"post", {"post", {"--post", "motion_blur"}}},
      {"shutter", {"post", {"--post", "motion_blur", "--shutter", "0.25"}}},
      {"blades", {"blades", {"--blades", "5"}}},
      {"blade-rotation", {"blade_rotation", {"--blade-rotation", "10"}}}};

  const auto log = [&](const std::string& out, const std::vector<std::string>& more) {
    const ProgramRun run = RunProgram(Render(out, more));
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    nlohmann::json json = nlohmann::json::parse(ReadText(out + "/render.json"));
    for (nlohmann::json& frame : json["frames"]) {
      frame = frame["frame"];  // times differ from run to run
    }
    return json;
  };
  const nlohmann::json plain = log(folder / "plain", {"--frames", "1"});
  std::set<std::string> known = same_pictures;
  int runs = 0;
  for (const auto& [option, row] : logged) {
    known.insert(option);
    ASSERT_TRUE(plain.contains(row.key)) << row.key;
    if (row.arguments.empty()) {
      EXPECT_FALSE(plain[row.key].get<std::string>().empty()) << row.key;
      continue;
    }
    std::vector<std::string> more = {"--frames", "1"};
    more.insert(more.end(), row.arguments.begin(), row.arguments.end());
    const std::string out = folder / std::to_string(runs++);
    const nlohmann::json changed = log(out, more);
    EXPECT_NE(changed[row.key], plain[row.key]) << option;
    EXPECT_THAT(changed["command"].get<std::string>(), HasSubstr(" " + row.arguments.back()))
        << option;
    if (row.key == std::string("environment")) {
      const ProgramRun report = RunProgram({"report", out});
      EXPECT_EQ(report.exit_code, 0) << report.errors;
    }
  }
  EXPECT_EQ(OptionsOf("render"), known);
}

// Pictures are passed on: they must not show the folders of the scene.
TEST(CliRuns, PicturesDoNotTellFolders) {
  const TemporaryFolder folder;
  const std::string scene = folder / "scene.gltf";
  WriteTriangle(scene);
  ASSERT_EQ(RunProgram(Render(folder / "out", {}, scene)).exit_code, 0);
  const Result<ExrImage> picture = ReadExr(folder / "out/denoised.0001.exr");
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture->attributes.at("scene"), "scene.gltf");
  EXPECT_THAT(ReadText(folder / "out/denoised.0001.exr"), Not(HasSubstr(folder.path())));
}

}  // namespace
}  // namespace stillray::cli_runs_test
