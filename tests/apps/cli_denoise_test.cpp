// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise, as a user runs it, on frames made here.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.h"
#include "stillray/io.h"

namespace stillray::cli_denoise_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kWidth = 32;
constexpr int kHeight = 20;

/// 0..1, the same for the same arguments.
float Noise(int x, int y, int frame) {
  uint32_t h = static_cast<uint32_t>(x) * 73856093u ^ static_cast<uint32_t>(y) * 19349663u ^
               static_cast<uint32_t>(frame) * 83492791u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return static_cast<float>((h ^ (h >> 16)) & 0xffff) / 65535.0f;
}

Image3 Constant(float value) {
  Image3 image(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    image[c].Fill(value);
  }
  return image;
}

/// A wall of colour 0.5 under noisy light of mean 1, as Blender would write it. `depth` and
/// `normal_axis` change at a cut.
ExrImage BlenderFrame(int frame, float depth = 4, int normal_axis = 2) {
  ExrImage image;
  image.width = kWidth;
  image.height = kHeight;
  Image3 light(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        light[c](x, y) = 2 * Noise(x, y, frame);
      }
    }
  }
  Image3 combined = light;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        combined[c](x, y) *= 0.5f;
      }
    }
  }
  Image3 normal(kWidth, kHeight);
  normal[normal_axis].Fill(1);
  Image1 z(kWidth, kHeight);
  z.Fill(depth);
  image.Add("ViewLayer.Combined.", PixelType::kHalf, combined);
  image.Add("ViewLayer.DiffDir.", PixelType::kHalf, light);
  image.Add("ViewLayer.DiffInd.", PixelType::kHalf, Constant(0));
  image.Add("ViewLayer.DiffCol.", PixelType::kHalf, Constant(0.5f));
  image.Add("ViewLayer.Normal.", PixelType::kFloat, normal, true);
  image.Add("ViewLayer.Depth.Z", PixelType::kFloat, z);
  image.Add("ViewLayer.Vector.X", PixelType::kFloat, Image1(kWidth, kHeight));
  image.Add("ViewLayer.Vector.Y", PixelType::kFloat, Image1(kWidth, kHeight));
  image.attributes["Camera"] = "camera";
  return image;
}

void WriteFrames(const std::string& pattern, int first, int last) {
  for (int frame = first; frame <= last; ++frame) {
    const Status written = WriteExr(FrameFileName(pattern, frame), BlenderFrame(frame));
    ASSERT_TRUE(written.ok()) << written.message();
  }
}

/// Mean squared difference of the written light from the wall's 0.5.
double Error(const std::string& path) {
  const Result<ExrImage> image = ReadExr(path);
  if (!image.ok()) {
    ADD_FAILURE() << image.status().message();
    return 1;
  }
  const Image1& red = image->Find("ViewLayer.Combined.R")->values;
  double sum = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      sum += (red(x, y) - 0.5) * (red(x, y) - 0.5);
    }
  }
  return sum / (kWidth * kHeight);
}

TEST(CliDenoise, CleansLightAndKeepsTheRest) {
  const TemporaryFolder folder;
  WriteFrames(folder / "in.####.exr", 3, 6);
  const ProgramRun run =
      RunProgram({"denoise", folder / "in.####.exr", "-o", folder / "new/out.####.exr", "--timings",
                  "--json", folder / "log.json"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("understood as frames of blender"));
  EXPECT_THAT(run.output, HasSubstr("atrous"));
  const double noise = Error(folder / "in.0006.exr");
  EXPECT_LT(Error(folder / "new/out.0006.exr"), noise / 20);
  EXPECT_FALSE(fs::exists(folder / "new/resume.stillray"));
  const Result<ExrImage> out = ReadExr(folder / "new/out.0003.exr");
  ASSERT_TRUE(out.ok());
  EXPECT_EQ(out->attributes.at("Camera"), "camera");
  EXPECT_EQ(out->Find("ViewLayer.DiffDir.R")->values(3, 3),
            ReadExr(folder / "in.0003.exr")->Find("ViewLayer.DiffDir.R")->values(3, 3));
  const auto json = nlohmann::json::parse(ReadText(folder / "log.json"));
  EXPECT_EQ(json["frames"].size(), 4u);
  EXPECT_EQ(json["aovs"]["renderer"], "blender");
  EXPECT_EQ(json["parameters"]["antialias"], "off");
  EXPECT_EQ(json["frames"][0]["restarted"], false);
  EXPECT_LT(json["frames"][1]["without_history"], 0.01);
}

TEST(CliDenoise, NegativeLightIsExplainedAndRoundingIsNone) {
  const TemporaryFolder folder;
  for (const auto& [name, value] :
       {std::pair("zero", 0.0f), {"rounding", -1e-6f}, {"low", -0.5f}}) {
    ExrImage image = BlenderFrame(1);
    for (const char* channel : {"R", "G", "B"}) {
      for (const char* layer : {"ViewLayer.DiffDir.", "ViewLayer.Combined."}) {
        Image1& values =
            std::find_if(image.channels.begin(), image.channels.end(), [&](const Channel& c) {
              return c.name == std::string(layer) + channel;
            })->values;
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            values(x, y) = Noise(x, y, 7) < 0.5f ? value : values(x, y);
          }
        }
      }
    }
    ASSERT_TRUE(WriteExr(folder / (std::string(name) + ".exr"), image).ok());
  }
  const auto denoise = [&](const std::string& name) {
    return RunProgram({"denoise", folder / (name + ".exr"), "-o", folder / (name + "_out.exr")});
  };
  ASSERT_EQ(denoise("zero").exit_code, 0);
  const ProgramRun rounding = denoise("rounding");
  ASSERT_EQ(rounding.exit_code, 0) << rounding.errors;
  EXPECT_THAT(rounding.errors, Not(HasSubstr("left out")));
  const double expected = Error(folder / "zero_out.exr");
  EXPECT_NEAR(Error(folder / "rounding_out.exr"), expected, 0.01 * expected);
  EXPECT_THAT(
      denoise("low").errors,
      HasSubstr("are negative by more than 1/1024 of the mean light; noisy light becomes too "
                "bright that way"));
}

TEST(CliDenoise, TakesFoldersListsAndRanges) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "in");
  WriteFrames(folder / "in/f.%04d.exr", 1, 3);
  ProgramRun run = RunProgram({"denoise", folder / "in", "-o", folder / "a/", "--frames", "2-3"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_FALSE(fs::exists(folder / "a/f.0001.exr"));
  run = RunProgram({"denoise", folder / "in/f.0002.exr", folder / "in/f.0003.exr", "-o",
                    folder / "b/g.#.exr", "--threads", "1"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_EQ(ReadText(folder / "a/f.0003.exr"), ReadText(folder / "b/g.3.exr"));
}

TEST(CliDenoise, CutsAndGapsRestartTheHistory) {
  const TemporaryFolder folder;
  WriteFrames(folder / "in.####.exr", 1, 3);
  ASSERT_TRUE(WriteExr(folder / "in.0004.exr", BlenderFrame(4, 40, 0)).ok());
  ASSERT_TRUE(WriteExr(folder / "in.0006.exr", BlenderFrame(6, 40, 0)).ok());
  const ProgramRun run =
      RunProgram({"denoise", folder / "in.####.exr", "-o", folder / "out.####.exr"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors,
              HasSubstr("note: frame 4: hardly anything of the frame before is found again"));
  EXPECT_THAT(run.errors, HasSubstr("note: frame 6: frames after 4 are missing"));
  // Behind the cut the picture is the one of a sequence that begins there.
  const ProgramRun alone = RunProgram(
      {"denoise", folder / "in.####.exr", "-o", folder / "alone.####.exr", "--frames", "4"});
  ASSERT_EQ(alone.exit_code, 0) << alone.errors;
  EXPECT_EQ(ReadText(folder / "out.0004.exr"), ReadText(folder / "alone.0004.exr"));
}

TEST(CliDenoise, WithoutMotionEveryFrameStandsAlone) {
  const TemporaryFolder folder;
  WriteFrames(folder / "in.####.exr", 1, 2);
  const std::vector<std::string> common = {"denoise", folder / "in.####.exr", "--aov",
                                           "motion=none"};
  std::vector<std::string> both = common;
  both.insert(both.end(), {"-o", folder / "a.####.exr"});
  std::vector<std::string> second = common;
  second.insert(second.end(), {"-o", folder / "b.####.exr", "--frames", "2"});
  const ProgramRun run = RunProgram(both);
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("no motion: every frame is denoised separately"));
  ASSERT_EQ(RunProgram(second).exit_code, 0);
  EXPECT_EQ(ReadText(folder / "a.0002.exr"), ReadText(folder / "b.0002.exr"));
}

// Files that exceed the limit are not decoded: their truncation is not reported.
TEST(CliDenoise, MemoryIsCheckedBeforeDecoding) {
  const TemporaryFolder folder;
  WriteFrames(folder / "in.####.exr", 1, 1);
  const std::string bytes = ReadText(folder / "in.0001.exr");
  ASSERT_TRUE(WriteFileAtomically(folder / "in.0001.exr", bytes.data(), bytes.size() / 2).ok());
  const std::vector<std::string> arguments = {"denoise", folder / "in.####.exr", "-o",
                                              folder / "out.####.exr"};
  const ProgramRun damaged = RunProgram(arguments);
  EXPECT_EQ(damaged.exit_code, 2);
  EXPECT_THAT(damaged.errors, HasSubstr("in.0001.exr: is a damaged EXR file"));
  std::vector<std::string> limited = arguments;
  limited.insert(limited.end(), {"--memory-limit", "100K"});
  const ProgramRun refused = RunProgram(limited);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.errors, HasSubstr("a frame of 32 x 20 pixels with 18 channels takes about"));
}

// Antialiased normals are shorter than 1 where surfaces meet.
TEST(CliDenoise, SoftEdgesRelaxTheTestsOfTheHistory) {
  const TemporaryFolder folder;
  for (int frame = 1; frame <= 2; ++frame) {
    ExrImage image = BlenderFrame(frame);
    for (Channel& channel : image.channels) {
      if (channel.name == "ViewLayer.Normal.Z") {
        for (int y = 0; y < kHeight; ++y) {
          channel.values(frame + 3, y) = 0.7f;
        }
      }
    }
    ASSERT_TRUE(WriteExr(FrameFileName(folder / "in.#.exr", frame), image).ok());
  }
  const auto parameters = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "denoise", folder / "in.#.exr", "-o", folder / "out.#.exr", "--json", folder / "log.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, HasSubstr("guides are antialiased or noisy"));
    return nlohmann::json::parse(ReadText(folder / "log.json"))["parameters"];
  };
  nlohmann::json used = parameters({});
  EXPECT_EQ(used["history_id"], "off");
  EXPECT_EQ(used["history_normal"], "80");
  EXPECT_EQ(used["history_depth"], "0.3");
  used = parameters({"--set", "history_normal=30"});
  EXPECT_EQ(used["history_normal"], "30");
  EXPECT_EQ(used["history_id"], "off");
  used = parameters({"--preset", "svgf"});
  EXPECT_EQ(used["history_id"], "on");
}

TEST(CliDenoise, JsonGoesThroughAPipeAlone) {
  const TemporaryFolder folder;
  WriteFrames(folder / "in.#.exr", 1, 2);
  const std::string command = std::string("'") + STILLRAY_PROGRAM + "' denoise '" +
                              (folder / "in.#.exr") + "' -o '" + (folder / "out.#.exr") +
                              "' --json - 2>/dev/null";
  std::FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
    text += static_cast<char>(c);
  }
  EXPECT_EQ(pclose(pipe), 0);
  const auto json = nlohmann::json::parse(text, nullptr, false);
  ASSERT_FALSE(json.is_discarded()) << text;
  EXPECT_EQ(json["frames"].size(), 2u);
}

TEST(CliDenoise, ErrorsAreOneLineAndNameTheCause) {
  const TemporaryFolder folder;
  WriteFrames(folder / "in.####.exr", 1, 2);
  const std::string in = folder / "in.####.exr";
  const std::string out = folder / "out.####.exr";
  const auto error = [](const std::vector<std::string>& arguments) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.errors;
    return run.errors;
  };
  EXPECT_THAT(error({"denoise", folder / "no.####.exr", "-o", out}),
              HasSubstr("no file matches this pattern"));
  EXPECT_THAT(error({"denoise", in, "-o", in}), HasSubstr("would overwrite the input"));
  EXPECT_THAT(error({"denoise", in, "-o", "out.####.png"}), HasSubstr("ends in .exr"));
  EXPECT_THAT(error({"denoise", in, "-o", folder / "one.exr"}), HasSubstr("expected a pattern"));
  EXPECT_THAT(error({"denoise", in, "-o", out, "--frames", "7-9"}),
              HasSubstr("the 2 files found are frames 1 to 2"));
  EXPECT_THAT(error({"denoise", in, "-o", out, "--frames", "x"}), HasSubstr("--frames is 'x'"));
  EXPECT_THAT(error({"denoise", in, "-o", out, "--renderer", "x"}), HasSubstr("--renderer is 'x'"));
  EXPECT_THAT(error({"denoise", in, "-o", out, "--memory-limit", "100K"}),
              HasSubstr("--memory-limit is 0.1 MB"));
  EXPECT_THAT(error({"denoise", in, "-o", out, "--memory-limit", "lots"}),
              HasSubstr("expected a size such as"));
  EXPECT_THAT(error({"denoise", in, "-o", out, "--set", "sigma=1"}), HasSubstr("--set: "));
  WriteFrames(folder / "other.####.exr", 1, 1);
  EXPECT_THAT(error({"denoise", folder.path(), "-o", out}), HasSubstr("holds 2 sequences"));
}

}  // namespace
}  // namespace stillray::cli_denoise_test
