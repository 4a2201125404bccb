// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray render, as a user runs it.
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.h"
#include "stillray/io.h"
#include "stillray/quality.h"

namespace stillray::cli_render_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::vector<std::string> Render(const std::string& folder, std::vector<std::string> more,
                                const std::string& scene = "builtin:cornell") {
  std::vector<std::string> all = {"render", scene,   "-o", folder,      "--size",
                                  "48x27",  "--fps", "15", "--bounces", "2"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

/// Pictures of two folders that are not the same byte for byte.
std::vector<std::string> Differences(const std::string& a, const std::string& b,
                                     const std::string& extension) {
  std::vector<std::string> different;
  for (const std::string& name : FilesIn(a)) {
    if (fs::path(name).extension() == extension &&
        ReadText((fs::path(a) / name).string()) != ReadText((fs::path(b) / name).string())) {
      different.push_back(name);
    }
  }
  return different;
}

TEST(CliRender, WritesWhatItPromises) {
  const TemporaryFolder folder;
  const std::string out = folder / "deep/er";
  const ProgramRun run =
      RunProgram(Render(out, {"--frames", "3-4", "--reference", "4", "--reference-frames", "4",
                              "--format", "exr,png", "--aov", "temporal,variance,normal",
                              "--save-inputs", "--timings", "--json", folder / "log.json"}));
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(
      FilesIn(out),
      (std::set<std::string>{
          "denoised.0003.exr", "denoised.0003.png", "denoised.0004.exr", "denoised.0004.png",
          "noisy.0003.exr", "noisy.0003.png", "noisy.0004.exr", "noisy.0004.png",
          "reference.0004.exr", "reference.0004.png", "render.json", "resume.stillray",
          "temporal.0003.exr", "temporal.0003.png", "temporal.0004.exr", "temporal.0004.png"}));
  EXPECT_THAT(run.output, HasSubstr("atrous"));
  EXPECT_THAT(run.errors, HasSubstr("frame 3 of 4"));
  const auto json = nlohmann::json::parse(ReadText(folder / "log.json"));
  EXPECT_EQ(json["frames"].size(), 2u);
  EXPECT_EQ(json["frames"][0]["frame"], 3);
  EXPECT_DOUBLE_EQ(json["frames"][0]["seconds"], 2.0 / 15);
  EXPECT_EQ(json["parameters"]["signals"], "split");

  const Result<ExrImage> denoised = ReadExr((fs::path(out) / "denoised.0004.exr").string());
  ASSERT_TRUE(denoised.ok());
  for (const char* name : {"R", "motion.X", "depth.Z", "normal.Y", "variance.direct.X"}) {
    EXPECT_NE(denoised->Find(name), nullptr) << name;
  }
  const Result<ExrImage> noisy = ReadExr((fs::path(out) / "noisy.0004.exr").string());
  ASSERT_TRUE(noisy.ok());
  for (const char* name : {"R", "direct_diffuse.R", "indirect_specular.B", "albedo.G", "id.X",
                           "emission.R", "background.B", "roughness.X"}) {
    EXPECT_NE(noisy->Find(name), nullptr) << name;
  }
  // The noisy picture is the sum of its parts.
  const float sum = noisy->Find("direct_diffuse.R")->values(20, 13) +
                    noisy->Find("indirect_diffuse.R")->values(20, 13) +
                    noisy->Find("direct_specular.R")->values(20, 13) +
                    noisy->Find("indirect_specular.R")->values(20, 13) +
                    noisy->Find("emission.R")->values(20, 13) +
                    noisy->Find("background.R")->values(20, 13);
  EXPECT_NEAR(noisy->Find("R")->values(20, 13), sum, 0.005f * sum);
}

std::vector<std::string> ChannelsOf(const std::string& path) {
  std::vector<std::string> names;
  const Result<ExrImage> image = ReadExr(path);
  EXPECT_TRUE(image.ok()) << path;
  for (const Channel& channel : image.ok() ? image->channels : std::vector<Channel>()) {
    names.push_back(channel.name);
  }
  return names;
}

// Bytes that a text such as "about 12.3 kB" names.
double BytesIn(const std::string& text, const std::string& before) {
  const size_t at = text.find(before);
  if (at == std::string::npos) {
    return 0;
  }
  size_t end = 0;
  const std::string rest = text.substr(at + before.size());
  const double value = std::stod(rest, &end);
  const std::string unit = rest.substr(end + 1, 2);
  return value * (unit == "kB" ? 1e3 : unit == "MB" ? 1e6 : unit == "GB" ? 1e9 : 1);
}

TEST(CliRender, WritesCleanFramesOnlyAndSaysHowMuchBeforeAndAfter) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const ProgramRun run = RunProgram({"render", "builtin:cornell", "-o", out, "--size", "160x90",
                                     "--frames", "1-3", "--format", "exr,png"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(FilesIn(out),
            (std::set<std::string>{"denoised.0001.exr", "denoised.0001.png", "denoised.0002.exr",
                                   "denoised.0002.png", "denoised.0003.exr", "denoised.0003.png",
                                   "render.json", "resume.stillray"}));
  EXPECT_THAT(ChannelsOf(out + "/denoised.0001.exr"),
              ::testing::UnorderedElementsAre("R", "G", "B"));
  double bytes = 0;
  for (const std::string& name : FilesIn(out)) {
    bytes +=
        name.starts_with("denoised") ? static_cast<double>(fs::file_size(out + "/" + name)) : 0;
  }
  EXPECT_THAT(run.errors, HasSubstr("writing 3 frames of 160 x 90 pixels to " + out + ", about "));
  const double estimated = BytesIn(run.errors, "to " + out + ", about ");
  EXPECT_GT(estimated, 0.5 * bytes);
  EXPECT_LT(estimated, 2.0 * bytes);
  EXPECT_THAT(run.output, HasSubstr("wrote 3 frames to " + out + "/ ("));
  EXPECT_NEAR(BytesIn(run.output, out + "/ ("), bytes, 0.06 * bytes);
}

TEST(CliRender, TheEstimateHoldsForInputsReferencesAndLayers) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const ProgramRun run =
      RunProgram({"render", "builtin:lights", "-o", out, "--size", "160x90", "--frames", "1-2",
                  "--format", "exr,png", "--save-inputs", "--reference", "2", "--aov", "temporal"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  // The layers that `stillray compare` needs for the temporal error.
  EXPECT_THAT(ChannelsOf(out + "/denoised.0002.exr"),
              ::testing::IsSupersetOf({"motion.X", "depth.Z"}));
  double bytes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(out)) {
    const std::string extension = entry.path().extension();
    bytes +=
        extension == ".exr" || extension == ".png" ? static_cast<double>(entry.file_size()) : 0;
  }
  const double estimated = BytesIn(run.errors, "to " + out + ", about ");
  EXPECT_GT(estimated, 0.5 * bytes);
  EXPECT_LT(estimated, 2.0 * bytes);
}

TEST(CliRender, WritesJpegPictures) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const ProgramRun run = RunProgram({"render", "builtin:cornell", "-o", out, "--size", "160x90",
                                     "--frames", "1", "--format", "png,jpg", "--save-inputs"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(FilesIn(out),
            (std::set<std::string>{"denoised.0001.jpg", "denoised.0001.png", "noisy.0001.jpg",
                                   "noisy.0001.png", "render.json", "resume.stillray"}));
  EXPECT_THAT(run.errors, HasSubstr("JPEG "));
  bool linear = true;
  const Image3 jpeg = ReadImage(out + "/denoised.0001.jpg", &linear).value();
  const Image3 png = ReadImage(out + "/denoised.0001.png").value();
  EXPECT_FALSE(linear);
  EXPECT_GT(MeasurePsnr(jpeg, png).value(), 35);
}

TEST(CliRender, ThreadsDoNotChangeBits) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "3"}) {
    const ProgramRun run = RunProgram(
        Render(folder / threads, {"--frames", "1-3", "--format", "exr,png", "--threads", threads}));
    ASSERT_EQ(run.exit_code, 0) << run.errors;
  }
  EXPECT_THAT(Differences(folder / "1", folder / "3", ".exr"), ::testing::IsEmpty());
  EXPECT_THAT(Differences(folder / "1", folder / "3", ".png"), ::testing::IsEmpty());
}

// With one thread, files are written before the next frame starts; below one sample per pixel the
// tracer clears only pixels that it stored.
TEST(CliRender, WritingBesideTheNextFrameChangesNothing) {
  const TemporaryFolder folder;
  for (const char* threads : {"1", "3"}) {
    const ProgramRun run = RunProgram(
        Render(folder / threads,
               {"--frames", "1-7", "--spp", "1/4", "--still", "--format", "exr,png", "--reference",
                "4", "--reference-frames", "2-3,6-6", "--threads", threads, "--timings"}));
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, HasSubstr("\n  write  "));
    size_t last = 0;
    for (int frame = 1; frame <= 7; ++frame) {
      const std::string line = "frame " + std::to_string(frame) + " of 7: render ";
      const size_t at = run.errors.find(line);
      ASSERT_NE(at, std::string::npos) << line << "\n" << run.errors;
      EXPECT_GE(at, last);
      last = at;
    }
  }
  EXPECT_EQ(FilesIn(folder / "1"), FilesIn(folder / "3"));
  EXPECT_THAT(Differences(folder / "1", folder / "3", ".exr"), ::testing::IsEmpty());
  EXPECT_THAT(Differences(folder / "1", folder / "3", ".png"), ::testing::IsEmpty());
}

TEST(CliRender, AFrameThatCannotBeWrittenStopsTheRun) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  fs::create_directories(out + "/denoised.0003.exr/in_the_way");
  const ProgramRun run =
      RunProgram(Render(out, {"--frames", "1-6", "--format", "exr", "--threads", "3"}));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("error: " + out + "/denoised.0003.exr: could not be written"));
  EXPECT_THAT(run.errors, HasSubstr("frame 2 of 6: render "));
  EXPECT_THAT(run.errors, ::testing::Not(HasSubstr("frame 3 of 6: render ")));
  EXPECT_EQ(FilesIn(out), (std::set<std::string>{"denoised.0001.exr", "denoised.0002.exr",
                                                 "denoised.0003.exr", "resume.stillray"}));
}

TEST(CliRender, SeedsAndSamplersChangeTheNoise) {
  const TemporaryFolder folder;
  const auto noisy = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> all = {"--frames", "1", "--format", "exr", "--save-inputs"};
    all.insert(all.end(), more.begin(), more.end());
    EXPECT_EQ(RunProgram(Render(folder / name, all)).exit_code, 0);
    return ReadText((folder / name) + "/noisy.0001.exr");
  };
  const std::string first = noisy("a", {});
  EXPECT_EQ(first, noisy("b", {}));
  EXPECT_NE(first, noisy("c", {"--seed", "1"}));
  EXPECT_NE(first, noisy("d", {"--sampler", "halton16"}));
}

TEST(CliRender, StillHoldsTheScene) {
  const TemporaryFolder folder;
  ASSERT_EQ(RunProgram(Render(folder.path(), {"--frames", "20-21", "--still", "--format", "exr",
                                              "--no-jitter", "--save-inputs"}))
                .exit_code,
            0);
  const Result<ExrImage> first = ReadExr(folder / "noisy.0020.exr");
  const Result<ExrImage> second = ReadExr(folder / "noisy.0021.exr");
  ASSERT_TRUE(first.ok() && second.ok());
  bool noise_differs = false;
  for (int y = 0; y < 27; ++y) {
    for (int x = 0; x < 48; ++x) {
      EXPECT_EQ(first->Find("depth.Z")->values(x, y), second->Find("depth.Z")->values(x, y));
      EXPECT_EQ(second->Find("motion.X")->values(x, y), 0.0f);
      noise_differs =
          noise_differs || first->Find("R")->values(x, y) != second->Find("R")->values(x, y);
    }
  }
  EXPECT_TRUE(noise_differs);
}

TEST(CliRender, LessThanOneSamplePerPixel) {
  const TemporaryFolder folder;
  for (const char* guides : {"full", "sparse"}) {
    const ProgramRun run = RunProgram(
        Render(folder / guides, {"--spp", "0.2", "--guides", guides, "--frames", "5-9", "--still",
                                 "--no-jitter", "--format", "exr,png", "--save-inputs"}));
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const auto json = nlohmann::json::parse(ReadText(folder / guides + "/render.json"));
    EXPECT_DOUBLE_EQ(json["spp"], 0.2);
    EXPECT_EQ(json["guides"], guides);
    EXPECT_EQ(json["frames"].size(), 5u);
    // Frames 5 to 9 are one cycle of five.
    int traced = 0;
    for (int frame = 5; frame <= 9; ++frame) {
      const Result<ExrImage> noisy =
          ReadExr(folder / guides + "/noisy.000" + std::to_string(frame) + ".exr");
      ASSERT_TRUE(noisy.ok());
      for (int y = 0; y < 27; ++y) {
        for (int x = 0; x < 48; ++x) {
          const bool sampled = noisy->Find("samples.X")->values(x, y) == 1.0f;
          traced += sampled;
          const bool known = noisy->Find("depth.Z")->values(x, y) > 0.0f;
          ASSERT_EQ(known, sampled || guides == std::string("full"));
          ASSERT_TRUE(sampled || noisy->Find("direct_diffuse.R")->values(x, y) == 0.0f);
        }
      }
    }
    EXPECT_EQ(traced, 27 * 48);
    const ProgramRun report = RunProgram({"report", folder / guides});
    EXPECT_EQ(report.exit_code, 0) << report.errors;
  }
}

TEST(CliRender, FractionsAndDecimalsAreTheSame) {
  const TemporaryFolder folder;
  const std::vector<std::string> common = {"--frames", "1-3", "--format", "exr"};
  const auto with = [&](const char* spp) {
    std::vector<std::string> all = {"--spp", spp};
    all.insert(all.end(), common.begin(), common.end());
    return all;
  };
  ASSERT_EQ(RunProgram(Render(folder / "a", with("1/3"))).exit_code, 0);
  ASSERT_EQ(RunProgram(Render(folder / "b", with("0.333"))).exit_code, 0);
  EXPECT_THAT(Differences(folder / "a", folder / "b", ".exr"), ::testing::IsEmpty());
  std::vector<std::string> again = with("0.33333");
  again.push_back("--resume");
  const ProgramRun resumed = RunProgram(Render(folder / "a", again));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("all frames are there already"));
}

TEST(CliRender, ASettingsFileSaysWhatOptionsSay) {
  const TemporaryFolder folder;
  std::ofstream(folder / "look.txt") << "# saved by the viewer\npreset=psvgf\nsigma_n=32\n"
                                     << "render.spp=1/4\nrender.guides=sparse\nrender.bounces=2\n";
  const std::string out = folder / "file";
  const ProgramRun from_file = RunProgram(
      Render(out, {"--frames", "1-3", "--format", "exr", "--settings", folder / "look.txt"}));
  ASSERT_EQ(from_file.exit_code, 0) << from_file.errors;
  ASSERT_EQ(RunProgram(Render(folder / "options", {"--frames", "1-3", "--format", "exr", "--preset",
                                                   "psvgf", "--set", "sigma_n=32", "--spp", "1/4",
                                                   "--guides", "sparse", "--bounces", "2"}))
                .exit_code,
            0);
  EXPECT_THAT(Differences(out, folder / "options", ".exr"), ::testing::IsEmpty());
  // The command line takes precedence.
  ASSERT_EQ(RunProgram(Render(folder / "own", {"--frames", "1-3", "--format", "exr", "--settings",
                                               folder / "look.txt", "--bounces", "3"}))
                .exit_code,
            0);
  EXPECT_THAT(Differences(out, folder / "own", ".exr"), ::testing::Not(::testing::IsEmpty()));
  const ProgramRun none =
      RunProgram(Render(folder / "none", {"--settings", folder / "missing.txt"}));
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.errors, HasSubstr("--settings: "));
  const ProgramRun both =
      RunProgram(Render(folder / "both", {"--settings", folder / "look.txt", "--preset", "svgf"}));
  EXPECT_EQ(both.exit_code, 2);
}

TEST(CliRender, JsonGoesToAPipe) {
  const TemporaryFolder folder;
  const ProgramRun run =
      RunProgram(Render(folder / "out", {"--frames", "1-1", "--format", "exr", "--json", "-"}));
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_NE(run.output.find("\"parameters\""), std::string::npos);
}

/// Starts a run, waits until some frames are there, and sends it `signal_number`.
int InterruptedRun(const std::vector<std::string>& arguments, const std::string& wait_for,
                   int signal_number) {
  const pid_t child = fork();
  if (child == 0) {
    std::vector<std::string> copy = arguments;
    copy.insert(copy.begin(), STILLRAY_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : copy) {
      argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    const int null = open("/dev/null", O_RDWR);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    execv(STILLRAY_PROGRAM, argv.data());
    _exit(127);
  }
  for (int i = 0; i < 3000 && !fs::exists(wait_for); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  kill(child, signal_number);
  int state = 0;
  waitpid(child, &state, 0);
  return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
}

TEST(CliRender, InterruptedAndResumedGivesTheSameBits) {
  const TemporaryFolder folder;
  const std::vector<std::string> settings = {"--frames", "1-40",   "--format",
                                             "exr,png",  "--size", "160x90"};
  ASSERT_EQ(RunProgram(Render(folder / "whole", settings)).exit_code, 0);
  const std::string out = folder / "part";
  ASSERT_EQ(InterruptedRun(Render(out, settings), out + "/denoised.0003.png", SIGINT), 130);
  const std::set<std::string> left = FilesIn(out);
  EXPECT_TRUE(left.count("resume.stillray"));
  EXPECT_FALSE(left.count("denoised.0040.png")) << "it was not interrupted";
  for (const std::string& name : left) {
    EXPECT_THAT(name, ::testing::Not(HasSubstr("tmp"))) << "half-written";
  }
  std::vector<std::string> again = settings;
  again.insert(again.end(), {"--resume", "--seed", "5"});
  const ProgramRun refused = RunProgram(Render(out, again));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("made with 'seed 0', this run has 'seed 5'"));

  again.resize(again.size() - 2);
  const ProgramRun resumed = RunProgram(Render(out, again));
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame"));
  EXPECT_THAT(Differences(folder / "whole", out, ".exr"), ::testing::IsEmpty());
  EXPECT_THAT(Differences(folder / "whole", out, ".png"), ::testing::IsEmpty());
  const auto json = nlohmann::json::parse(ReadText(out + "/render.json"));
  EXPECT_EQ(json["frames"].size(), 40u);
  EXPECT_THAT(json["machine"].get<std::string>(), HasSubstr(" threads"));
  EXPECT_THAT(json["date"].get<std::string>(), ::testing::MatchesRegex("....-..-..T..:..:..Z"));
  EXPECT_GT(json["frames"][39]["write_ms"], 0);

  const ProgramRun complete = RunProgram(Render(out, again));
  EXPECT_EQ(complete.exit_code, 0);
  EXPECT_THAT(complete.errors, HasSubstr("all frames are there already"));
}

TEST(CliRender, ADamagedResumeFileIsNamed) {
  const TemporaryFolder folder;
  const std::string out = folder / "o";
  fs::create_directory(out);
  for (const auto& [bytes, message] :
       {std::pair<std::string, std::string>("xx", "is damaged"),
        {"stillray resume 3\nxx", "is damaged"},
        {"stillray resume 1\nxx", "was saved by another version of stillray"}}) {
    ASSERT_TRUE(WriteFileAtomically(out + "/resume.stillray", bytes.data(), bytes.size()).ok());
    const ProgramRun run = RunProgram(Render(out, {"--frames", "1", "--resume"}));
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr("resume.stillray " + message));
  }
}

TEST(CliRender, VideoHasAllFrames) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "ffmpeg is not installed";
  }
  const TemporaryFolder folder;
  const ProgramRun run = RunProgram(Render(folder.path(), {"--frames", "1-5", "--format", "mp4"}));
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(FilesIn(folder.path()),
            (std::set<std::string>{"denoised.mp4", "render.json", "resume.stillray"}));
  EXPECT_GT(fs::file_size(folder / "denoised.mp4"), 500u);
}

TEST(CliRender, BadInputIsNamed) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  struct Case {
    std::vector<std::string> arguments;
    const char* message;
  };
  const Case cases[] = {
      {{"--size", "0x0"}, "--size is '0x0'"},
      {{"--size", "12"}, "--size is '12'"},
      {{"--size", "32768x32768"}, "GB; this machine has"},
      {{"--frames", "9-3"}, "--frames is '9-3'"},
      {{"--frames", "x"}, "--frames is 'x'"},
      {{"--spp", "0"}, "--spp is '0', expected 1 to 65536, or 1/2 to 1/256"},
      {{"--spp", "-1"}, "--spp is '-1'"},
      {{"--spp", "1/1"}, "--spp is '1/1'"},
      {{"--spp", "1/257"}, "--spp is '1/257'"},
      {{"--spp", "2/3"}, "--spp is '2/3'"},
      {{"--spp", "0.4"}, "--spp is '0.4'"},
      {{"--spp", "1.5"}, "--spp is '1.5'"},
      {{"--spp", "nan"}, "--spp is 'nan'"},
      {{"--spp", "1e-9"}, "--spp is '1e-9'"},
      {{"--guides", "none"}, "--guides is 'none', expected full or sparse"},
      {{"--guides", "sparse", "--spp", "2"}, "--guides sparse is for --spp below 1"},
      {{"--bounces", "33"}, "--bounces is '33', expected a whole number from 1 to 32"},
      {{"--fps", "0"}, "--fps: found '0', expected 0.001 to 1000"},
      {{"--preset", "nope"}, "unknown preset 'nope'; presets are: default"},
      {{"--set", "sigma_l"}, "--set: 'sigma_l' has no '=', expected name=value"},
      {{"--set", "sigma_l=-1"}, "parameter 'sigma_l' is '-1', expected a number from"},
      {{"--set", "nope=1"}, "unknown parameter 'nope'"},
      {{"--sampler", "nope"}, "--sampler is 'nope', expected one of sobol, halton16, zsobol"},
      {{"--aov", "nope"}, "--aov has 'nope'"},
      {{"--aov", "variance", "--format", "png"}, "add exr to --format"},
      {{"--format", "gif"}, "--format has 'gif'"},
      {{"--camera", "nope"}, "--camera is 'nope', the scene has: "},
      {{"--environment", "nope.hdr"}, "nope.hdr"},
      {{"--reference", "-1"}, "--reference: found '-1', expected 1 to 1048576"},
      {{"--ray-tracing", "nope"},
       "--ray-tracing: found 'nope', expected auto, hardware or compute"},
      {{"--reference-frames", "1"}, "--reference-frames needs --reference"},
      {{"--tonemap", "nope"}, "parameter 'tonemap' is 'nope', expected one of linear"},
      {{"--exposure", "99"}, "parameter 'exposure' is '99'"},
  };
  for (const Case& c : cases) {
    const ProgramRun run = RunProgram(Render(out, c.arguments));
    EXPECT_EQ(run.exit_code, 2) << c.message;
    EXPECT_THAT(run.errors, HasSubstr(c.message));
    EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
    EXPECT_FALSE(fs::exists(out)) << c.message << ": something was written";
  }
}

TEST(CliRender, BadScenesAndFoldersAreNamed) {
  const TemporaryFolder folder;
  const std::string scene = folder / "broken.glb";
  ASSERT_TRUE(WriteFileAtomically(scene, "glTF\2\0\0\0\377", 9).ok());
  const ProgramRun broken = RunProgram(Render(folder / "out", {}, scene));
  EXPECT_EQ(broken.exit_code, 2);
  EXPECT_THAT(broken.errors, HasSubstr("broken.glb"));
  const ProgramRun missing = RunProgram(Render(folder / "out", {}, folder / "none.glb"));
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.errors, HasSubstr("none.glb: no such file"));
  const ProgramRun unknown = RunProgram(Render(folder / "out", {}, "builtin:none"));
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(
      unknown.errors,
      HasSubstr("cornell, spheres, lights, materials, mirrors, thin, faust, colonnade, car"));
  EXPECT_FALSE(fs::exists(folder / "out"));

  const ProgramRun file = RunProgram(Render(scene, {"--frames", "1"}));
  EXPECT_EQ(file.exit_code, 2);
  EXPECT_THAT(file.errors, HasSubstr("cannot make the folder"));
}

TEST(CliRender, AFullDiskLeavesNothingHalfWritten) {
  // A limit on the size of files stands for the full disk: 8 KB, less than any EXR file here.
  const TemporaryFolder folder;
  const std::string command = std::string("ulimit -f 8; '") + STILLRAY_PROGRAM +
                              "' render builtin:cornell -o '" + (folder / "out") +
                              "' --size 160x90 --frames 1 --format exr >/dev/null 2>'" +
                              (folder / "errors") + "'";
  const int state = std::system(command.c_str());
  EXPECT_TRUE(WIFEXITED(state) && WEXITSTATUS(state) == 2);
  EXPECT_THAT(ReadText(folder / "errors"), HasSubstr("denoised.0001.exr"));
  EXPECT_TRUE(FilesIn(folder / "out").empty());
}

TEST(CliRender, HelpHasExamples) {
  for (const char* command : {"render", "compare", "report", "info", "bench"}) {
    const ProgramRun run = RunProgram({command, "--help"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_THAT(run.output, HasSubstr("xample")) << command;
  }
}

}  // namespace
}  // namespace stillray::cli_render_test
