// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Help, and messages for wrong command lines.
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/program.h"
#include "stillray/io.h"

namespace stillray::cli_usage_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// One line and exit code 2, and none of the folder.
void ExpectRefused(const std::vector<std::string>& arguments, const std::string& line) {
  const ProgramRun run = RunProgram(arguments);
  SCOPED_TRACE(testing::PrintToString(arguments));
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.output, IsEmpty());
  EXPECT_THAT(run.errors, HasSubstr(line));
  EXPECT_THAT(run.errors, StartsWith("stillray: error: "));
  EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
  EXPECT_LT(run.errors.size(), 250u) << run.errors;
}

TEST(CliUsage, NearestNames) {
  ExpectRefused({"rendr", "x.glb"}, "unknown command 'rendr', did you mean render?");
  ExpectRefused({"fly"}, "unknown command 'fly'; commands are: render, denoise, ");
  ExpectRefused({"--verson"}, "unknown option '--verson', did you mean --version?");
  ExpectRefused({"render", "builtin:cornell", "-o", "x", "--presett", "svgf"},
                "unknown option '--presett', did you mean --preset?");
  ExpectRefused({"render", "builtin:cornell", "--outptu=x"},
                "unknown option '--outptu', did you mean --output?");
  ExpectRefused({"denoise", "a.####.exr", "-o", "x", "--windw", "both"},
                "unknown option '--windw', did you mean --window?");
  ExpectRefused({"render", "builtin:cornell", "-o", "x", "--blue"},
                "unknown option '--blue'; stillray render --help lists all of them");
  ExpectRefused({"render", "builtin:cornell", "-o", "x", "--set", "sigmal=3"},
                "--set: unknown parameter 'sigmal', did you mean sigma_l?");
}

TEST(CliUsage, NearestValues) {
  const auto render = [](const std::string& option, const std::string& value) {
    return std::vector<std::string>{"render", "builtin:cornell", "-o", "x", option, value};
  };
  ExpectRefused(render("--preset", "defualt"), "unknown preset 'defualt', did you mean default?");
  ExpectRefused(render("--sampler", "sobel"),
                "expected one of sobol, halton16, zsobol, did you mean sobol?");
  ExpectRefused(render("--tonemap", "flimic"), ", did you mean filmic?");
  ExpectRefused(render("--format", "exr,pgn"), ", did you mean png?");
  ExpectRefused(render("--ray-tracing", "hardwear"), ", did you mean hardware?");
  ExpectRefused(render("--device", "vulcan"), ", did you mean vulkan?");
  ExpectRefused(render("--device", "gpu"), ", did you mean vulkan?");
  ExpectRefused({"denoise", "a.####.exr", "-o", "x", "--window", "bot"}, ", did you mean both?");
  ExpectRefused({"render", "builtin:cornel", "-o", "x"},
                "there is no built-in scene 'cornel', did you mean cornell?");
  ExpectRefused({"render", "cornell", "-o", "x"},
                "cornell: no such file, did you mean builtin:cornell?");
  ExpectRefused({"render", "bultin:lights", "-o", "x"}, ", did you mean builtin:lights?");
  // --aov lists many names before the nearest.
  EXPECT_THAT(RunProgram(render("--aov", "temporl")).errors, HasSubstr(", did you mean temporal?"));
}

TEST(CliUsage, OverviewAndHelp) {
  const ProgramRun bare = RunProgram({});
  EXPECT_EQ(bare.exit_code, 0);
  EXPECT_THAT(bare.errors, IsEmpty());
  EXPECT_THAT(bare.output, AllOf(HasSubstr("  stillray render"), HasSubstr("  stillray denoise"),
                                 HasSubstr("  stillray view"), HasSubstr("stillray help")));
  EXPECT_LT(std::count(bare.output.begin(), bare.output.end(), '\n'), 15);
  const ProgramRun all = RunProgram({"help"});
  EXPECT_EQ(all.exit_code, 0);
  EXPECT_THAT(all.output, AllOf(HasSubstr("render"), HasSubstr("denoise"), HasSubstr("report")));
  EXPECT_EQ(RunProgram({"--help"}).output, all.output);
  for (const std::string command : {"render", "denoise", "view", "check"}) {
    const ProgramRun help = RunProgram({"help", command});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_EQ(help.output, RunProgram({command, "--help"}).output);
    EXPECT_THAT(help.output, HasSubstr("stillray " + command));
  }
  ExpectRefused({"help", "rendr"}, "unknown command 'rendr', did you mean render?");
}

TEST(CliUsage, OptionsOfRenderAreGrouped) {
  const std::string help = RunProgram({"render", "--help"}).output;
  const auto place = [&](const std::string& text) {
    const size_t at = help.find(text);
    EXPECT_NE(at, std::string::npos) << text;
    return at;
  };
  const std::pair<const char*, std::vector<const char*>> kGroups[] = {
      {"\nScene:\n", {"--frames", "--fps", "--still", "--camera", "--environment"}},
      {"\nSampling:\n", {"--spp", "--bounces", "--seed", "--sampler", "--reference"}},
      {"\nDenoiser:\n", {"--preset", "--set"}},
      {"\nDevice:\n", {"--device", "--trace-device", "--verbose", "--threads"}},
      {"\nOutput:\n", {"--output", "--format", "--aov", "--json"}}};
  for (const auto& [group, options] : kGroups) {
    const size_t begin = place(group);
    size_t end = help.size();
    for (const auto& other : kGroups) {
      end = place(other.first) > begin ? std::min(end, place(other.first)) : end;
    }
    for (const char* option : options) {
      const size_t at = help.find(std::string(option) + " ", begin);
      EXPECT_LT(at, end) << option << " is not below " << group;
    }
  }
}

TEST(CliUsage, NumbersAreWhatTheySay) {
  const auto render = [](const std::string& option, const std::string& value) {
    return std::vector<std::string>{"render", "builtin:cornell", "-o", "x", option, value};
  };
  ExpectRefused(render("--seed", "-1"), "--seed is '-1', expected a whole number from 0 to 1844");
  ExpectRefused(render("--seed", "18446744073709551616"), "--seed is '18446744073709551616'");
  ExpectRefused(render("--seed", "1.5"), "--seed is '1.5', expected a whole number");
  ExpectRefused(render("--seed", "0x10"), "--seed is '0x10', expected a whole number");
  ExpectRefused(render("--bounces", "99999999999"), "--bounces is '99999999999', expected a ");
  ExpectRefused(render("--exposure", "abc"), "--exposure: found 'abc', expected a number");
  ExpectRefused({"report", "x", "--max-size", "nan"}, "--max-size: found 'nan', expected a number");
  // Leading zeros change nothing.
  const TemporaryFolder folder;
  for (const std::string seed : {"010", "10", "8"}) {
    const ProgramRun run =
        RunProgram({"render", "builtin:cornell", "-o", folder / seed, "--size", "16x16", "--frames",
                    "1", "--seed", seed, "--format", "exr"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
  }
  const auto picture = [&](const std::string& seed) {
    return ReadText(folder / (seed + "/denoised.0001.exr"));
  };
  EXPECT_EQ(picture("010"), picture("10"));
  EXPECT_NE(picture("010"), picture("8"));
}

TEST(CliUsage, TheDeviceIsOneShortLine) {
  const TemporaryFolder folder;
  const auto render = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"render", "builtin:cornell", "-o", folder / "out", "--size", "16x16",
                               "--frames", "1", "--format", "exr", "--threads", "2"});
    const ProgramRun run = RunProgram(more);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return run.errors;
  };
  // The test's environment hides all drivers.
  EXPECT_THAT(render({}), StartsWith("rendering on the CPU, 2 threads; no Vulkan driver\n"));
  EXPECT_THAT(render({}), Not(HasSubstr("Vulkan:")));
  EXPECT_THAT(render({"-v"}), HasSubstr("\nVulkan: "));
  EXPECT_THAT(render({"--device", "cpu"}), StartsWith("rendering on the CPU, 2 threads\n"));
}

TEST(CliUsage, ViewShowsABuiltInSceneWhereNoneIsNamed) {
  const TemporaryFolder folder;
  const ProgramRun run =
      RunProgram({"view", "--headless-frames", "1", "--size", "32x32", "-o", folder / "out"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_FALSE(std::filesystem::is_empty(folder / "out"));
}

TEST(CliUsage, RenderTakesABuiltInSceneAndAFolderWhereNoneIsNamed) {
  const TemporaryFolder folder;
  const std::string before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const ProgramRun run = RunProgram({"render", "--size", "32x32", "--frames", "1-2", "--format",
                                     "png", "--reference", "4", "--reference-frames", "2"});
  std::filesystem::current_path(before);
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, StartsWith("no scene is named: rendering builtin:cornell; others: "
                                     "builtin:spheres, "));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/denoised.0002.png"));
  EXPECT_THAT(run.output, HasSubstr("wrote 2 frames to out/ ("));
  EXPECT_THAT(run.output, HasSubstr("\nfiles: denoised.####.png, reference.####.png\n"));
  EXPECT_THAT(run.output, HasSubstr("\nagainst the reference, 1 frame: PSNR "));
  EXPECT_THAT(run.output, HasSubstr(" dB (noisy: "));
}

TEST(CliUsage, ControlCharactersAreEscaped) {
  const std::string name = "a\nb\x1b[31mc.exr";
  const std::string shown = "a\\nb\\x1b[31mc.exr";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"info", name},
        {"check", name},
        {"compare", name, name},
        {"denoise", name, "-o", "out"},
        {"render", "builtin:cornell", "-o", "out", "--environment", name},
        {"render", "builtin:cornell", "-o", "out", "--size", name},
        {"render", "builtin:cornell", "-o", "out", "--set", name},
        {"render", name, "-o", "out"},
        {name},
        {"render", "--" + name}}) {
    const ProgramRun run = RunProgram(arguments);
    SCOPED_TRACE(testing::PrintToString(arguments));
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr(shown));
    EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
    EXPECT_EQ(run.errors.find('\x1b'), std::string::npos);
  }
  ExpectRefused({"report", name}, "a b [31mc.exr: no such folder");
}

TEST(CliUsage, NamesInBracketsAreNoLists) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "[a,b]");
  const std::string before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"check", "[a,b]"}, {"denoise", "[a,b]", "-o", "out"}}) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.errors, HasSubstr("[a,b]"));
    EXPECT_THAT(run.errors, Not(HasSubstr("no such file"))) << run.errors;
  }
  std::filesystem::current_path(before);
}

TEST(CliUsage, PipesInPlaceOfFilesAreRefused) {
  const TemporaryFolder folder;
  const std::string pipe = folder / "x.0001.exr";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"info", pipe},
        {"check", pipe},
        {"compare", pipe, pipe},
        {"denoise", pipe, "-o", folder / "out/"},
        {"render", "builtin:cornell", "-o", folder / "out", "--environment", pipe},
        {"render", "builtin:cornell", "-o", folder / "out", "--settings", pipe},
        {"info", "/dev/zero"}}) {
    ExpectRefused(arguments, ": is not an ordinary file");
  }
  const std::string report = folder / "report";
  std::filesystem::create_directory(report);
  ASSERT_EQ(mkfifo((report + "/denoised.0001.png").c_str(), 0600), 0);
  ExpectRefused({"report", report}, ": is not an ordinary file");
}

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define STILLRAY_ADDRESS_SANITIZER
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define STILLRAY_ADDRESS_SANITIZER
#endif
#ifdef STILLRAY_ADDRESS_SANITIZER
constexpr bool kLimitsWork = false;  // the sanitizer reserves terabytes of address space
#else
constexpr bool kLimitsWork = true;
#endif

/// Limits a resource of the programs started during its lifetime.
class ResourceLimit {
 public:
  ResourceLimit(int resource, rlim_t most) : resource_(resource) {
    getrlimit(kind(), &before_);
    const rlimit limit = {most, before_.rlim_max};
    set_ = kLimitsWork && setrlimit(kind(), &limit) == 0;
  }
  ~ResourceLimit() { setrlimit(kind(), &before_); }
  ResourceLimit(const ResourceLimit&) = delete;
  ResourceLimit& operator=(const ResourceLimit&) = delete;
  bool set() const { return set_; }

 private:
  __rlimit_resource kind() const { return static_cast<__rlimit_resource>(resource_); }
  int resource_;
  rlimit before_{};
  bool set_ = false;
};

// A file of some kilobytes that would take gigabytes once decoded.
TEST(CliUsage, WhatDoesNotFitIntoMemoryIsRefusedBySize) {
  const TemporaryFolder folder;
  const std::string path = folder / "black.exr";
  ExrImage image;
  image.width = 4096;
  image.height = 4096;
  image.Add("", PixelType::kHalf, Image3(image.width, image.height));
  ASSERT_TRUE(WriteExr(path, image).ok());
  image = ExrImage();
  const ResourceLimit limit(RLIMIT_AS, rlim_t{500} << 20);
  if (!limit.set()) {
    GTEST_SKIP() << "the address space cannot be limited here";
  }
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"info", path}, {"check", path}, {"compare", path, path}}) {
    ExpectRefused(arguments,
                  path + ": a picture of 4096 x 4096 pixels with 3 channels takes about");
  }
}

TEST(CliUsage, ThreadsThatCannotBeStartedAreTheMachinesFault) {
  const TemporaryFolder folder;
  // A stack for each thread that does not fit into the address space.
  const ResourceLimit stack(RLIMIT_STACK, rlim_t{1} << 40);
  const ResourceLimit space(RLIMIT_AS, rlim_t{4} << 30);
  if (!stack.set() || !space.set()) {
    GTEST_SKIP() << "stacks and address space cannot be limited here";
  }
  const ProgramRun run =
      RunProgram({"render", "builtin:cornell", "-o", folder / "out", "--size", "32x32", "--frames",
                  "1-3", "--format", "exr", "--device", "cpu", "--threads", "2"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("stillray: error: no thread could be started"));
}

TEST(CliUsage, AnEmptySceneName) {
  const TemporaryFolder folder;
  ExpectRefused({"render", "", "-o", folder / "out"}, "the scene's name is empty");
  ExpectRefused({"info", ""}, "the name of the file is empty");
}

}  // namespace
}  // namespace stillray::cli_usage_test
