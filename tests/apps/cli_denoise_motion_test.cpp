// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise --motion: files whose motion is zero or missing.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_motion_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::json;

enum class Vectors { kTrue, kZero, kNone };

/// The colour of the shot's wall at column u of its own: stripes of irregular width and two rows.
float ColourAt(int u, int y) {
  return 0.3f + 0.4f * ShotNoise(u / 3, y / 4, 5) + 0.2f * ShotNoise(u / 7, y / 3, 6);
}

/// The shot with a texture that reveals its motion.
ExrImage TexturedFrame(const Shot& shot, int64_t frame, Vectors vectors) {
  ExrImage image = ShotFrame(shot, frame);
  const auto plane = [&](const std::string& name) -> Image1& {
    const auto at =
        std::find_if(image.channels.begin(), image.channels.end(),
                     [&](const Channel& channel) { return channel.name == "ViewLayer." + name; });
    return at->values;
  };
  for (const char* colour : {"R", "G", "B"}) {
    Image1& combined = plane(std::string("Combined.") + colour);
    Image1& light = plane(std::string("DiffDir.") + colour);
    Image1& albedo = plane(std::string("DiffCol.") + colour);
    for (int y = 0; y < Shot::kHeight; ++y) {
      for (int x = 0; x < Shot::kWidth; ++x) {
        albedo(x, y) = ColourAt(x + shot.speed * static_cast<int>(frame), y);
        combined(x, y) = light(x, y) * albedo(x, y);
      }
    }
  }
  if (vectors == Vectors::kNone) {
    std::erase_if(image.channels, [](const Channel& channel) {
      return channel.name.starts_with("ViewLayer.Vector.");
    });
  } else if (vectors == Vectors::kZero) {
    for (const char* letter : {"X", "Y", "Z", "W"}) {
      plane(std::string("Vector.") + letter).Fill(0);
    }
  }
  return image;
}

void WriteTexturedShot(const std::string& pattern, const Shot& shot, int64_t frames,
                       Vectors vectors) {
  for (int64_t frame = 1; frame <= frames; ++frame) {
    const Status written =
        WriteExr(FrameFileName(pattern, frame), TexturedFrame(shot, frame, vectors));
    ASSERT_TRUE(written.ok()) << written.message();
  }
}

/// Mean squared difference of the light of a written frame from the true light, away from the
/// borders.
double LightError(const std::string& pattern, const Shot& shot, int64_t frame) {
  const Result<ExrImage> image = ReadExr(FrameFileName(pattern, frame));
  if (!image.ok()) {
    ADD_FAILURE() << image.status().message();
    return 1e9;
  }
  constexpr int kMargin = 12;
  const Image1& green = image->Find("ViewLayer.Combined.G")->values;
  double sum = 0;
  int count = 0;
  for (int y = 0; y < Shot::kHeight; ++y) {
    for (int x = kMargin; x < Shot::kWidth - kMargin; ++x, ++count) {
      const int u = x + shot.speed * static_cast<int>(frame);
      const double error = static_cast<double>(green(x, y) / ColourAt(u, y) - TrueLight(shot, u));
      sum += error * error;
    }
  }
  return sum / count;
}

/// The camera of the shot: the wall at depth 4 goes by one pixel where it goes by 1/6.
Json CameraOfShot(const Shot& shot, int64_t frame) {
  constexpr double kFocal = 24;
  const double x = static_cast<double>(shot.speed) * static_cast<double>(frame) *
                   static_cast<double>(shot.depth) / kFocal;
  const std::vector<double> view = {1, 0, 0, -x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const std::vector<double> projection = {2 * kFocal / Shot::kWidth,
                                          0,
                                          0,
                                          0,
                                          0,
                                          2 * kFocal / Shot::kHeight,
                                          0,
                                          0,
                                          0,
                                          0,
                                          -1.002,
                                          -0.2002,
                                          0,
                                          0,
                                          -1,
                                          0};
  return {{"frame", frame},
          {"type", "perspective"},
          {"world_to_camera", view},
          {"projection", projection}};
}

std::string WriteCameras(const TemporaryFolder& folder, const Shot& shot, int64_t frames) {
  Json json = {{"version", 1}, {"width", Shot::kWidth}, {"height", Shot::kHeight}};
  for (int64_t frame = 1; frame <= frames; ++frame) {
    json["frames"].push_back(CameraOfShot(shot, frame));
  }
  const std::string path = folder / "cameras.json";
  const std::string text = json.dump();
  EXPECT_TRUE(WriteFileAtomically(path, text.data(), text.size()).ok());
  return path;
}

ProgramRun Denoise(const std::string& in, const std::string& out, std::vector<std::string> more) {
  std::vector<std::string> arguments = {"denoise", in, "-o", out + "/f.####.exr"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunProgram(arguments);
}

class CliDenoiseMotion : public ::testing::TestWithParam<const char*> {
 protected:
  static constexpr int64_t kFrames = 12;
  static constexpr int64_t kMiddle = 8;

  /// Denoises the shot and returns its error.
  double Error(Vectors vectors, const std::string& name, std::vector<std::string> more,
               ProgramRun* run = nullptr) {
    const std::string in = folder_ / (name + ".in.####.exr");
    WriteTexturedShot(in, shot_, kFrames, vectors);
    more.insert(more.end(), {"--window", GetParam()});
    const ProgramRun done = Denoise(in, folder_ / name, more);
    EXPECT_EQ(done.exit_code, 0) << done.errors;
    if (run != nullptr) {
      *run = done;
    }
    return LightError(folder_ / name + "/f.####.exr", shot_, kMiddle);
  }

  TemporaryFolder folder_;
  Shot shot_;
};

TEST_P(CliDenoiseMotion, ZerosAreReplaced) {
  const double best = Error(Vectors::kTrue, "true", {});
  const double as_it_is = Error(Vectors::kZero, "file", {"--motion", "file"});
  ProgramRun run;
  const double replaced = Error(Vectors::kZero, "auto", {"--json", folder_ / "log.json"}, &run);
  EXPECT_LT(replaced, 1.2 * best);
  EXPECT_LT(replaced, 0.6 * as_it_is);
  EXPECT_THAT(run.errors, AllOf(HasSubstr("frame 2: motion is zero in the file; it is estimated"),
                                Not(HasSubstr("motion_zero")), Not(HasSubstr("frame 3: motion"))));
  const Json log = Json::parse(ReadText(folder_ / "log.json"));
  EXPECT_EQ(log["frames"][1]["motion"], "estimate");
  EXPECT_LT(log["frames"][1]["motion_unknown"], 0.2);
}

TEST_P(CliDenoiseMotion, NoneIsReplaced) {
  ProgramRun run;
  const double best = Error(Vectors::kTrue, "true", {});
  EXPECT_LT(Error(Vectors::kNone, "auto", {}, &run), 1.2 * best);
  EXPECT_THAT(run.output, HasSubstr("motion is estimated from the guides"));
  EXPECT_THAT(run.output + run.errors,
              Not(::testing::AnyOf(HasSubstr("motion_missing"), HasSubstr("no motion:"))));
  const double alone = Error(Vectors::kNone, "alone", {"--aov", "motion=none"}, &run);
  EXPECT_GT(alone, 2 * best);
}

TEST_P(CliDenoiseMotion, TrueMotionIsKept) {
  ProgramRun run;
  Error(Vectors::kTrue, "auto", {"--json", folder_ / "log.json"}, &run);
  Error(Vectors::kTrue, "file", {"--motion", "file"});
  EXPECT_EQ(Json::parse(ReadText(folder_ / "log.json"))["frames"][1]["motion"], "file");
  for (int64_t frame = 1; frame <= kFrames; ++frame) {
    EXPECT_TRUE(ReadText(FrameFileName(folder_ / "auto/f.####.exr", frame)) ==
                ReadText(FrameFileName(folder_ / "file/f.####.exr", frame)))
        << frame;
  }
}

TEST_P(CliDenoiseMotion, CamerasFromAFile) {
  const std::string cameras = WriteCameras(folder_, shot_, kFrames);
  const double best = Error(Vectors::kTrue, "true", {});
  for (const char* motion : {"auto", "camera", "estimate"}) {
    ProgramRun run;
    const double error =
        Error(Vectors::kNone, motion, {"--motion", motion, "--cameras", cameras}, &run);
    EXPECT_NEAR(error, best, 0.05 * best) << motion;
    EXPECT_THAT(run.output, HasSubstr("motion is derived from depth and the cameras (" + cameras));
  }
}

// The run stops at frame 5, whose file cannot be written.
TEST_P(CliDenoiseMotion, AResumedRunHasTheSameBits) {
  Error(Vectors::kNone, "whole", {});
  const std::string in = folder_ / "whole.in.####.exr";
  const std::string part = folder_ / "part";
  const std::string blocked = part + "/f.0005.exr";
  fs::create_directories(blocked + "/in_the_way");
  EXPECT_EQ(Denoise(in, part, {"--window", GetParam()}).exit_code, 2);
  fs::remove_all(blocked);
  const ProgramRun other =
      Denoise(in, part, {"--window", GetParam(), "--motion", "estimate", "--resume"});
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr("motion auto"));
  const ProgramRun resumed = Denoise(in, part, {"--window", GetParam(), "--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame 5"));
  for (int64_t frame = 1; frame <= kFrames; ++frame) {
    EXPECT_TRUE(ReadText(FrameFileName(folder_ / "whole/f.####.exr", frame)) ==
                ReadText(FrameFileName(part + "/f.####.exr", frame)))
        << frame;
  }
}

// Too little to hold the motion of a block: it is estimated again for every pass.
TEST_P(CliDenoiseMotion, AMemoryLimitChangesNoBits) {
  Error(Vectors::kNone, "free", {});
  const std::string in = folder_ / "free.in.####.exr";
  const ProgramRun refused =
      Denoise(in, folder_ / "narrow", {"--window", GetParam(), "--memory-limit", "1K"});
  EXPECT_EQ(refused.exit_code, 2);
  const std::string marker = "takes about ";
  const size_t at = refused.errors.find(marker);
  ASSERT_NE(at, std::string::npos) << refused.errors;
  const double megabytes = std::stod(refused.errors.substr(at + marker.size())) + 0.1;
  const ProgramRun narrow =
      Denoise(in, folder_ / "narrow",
              {"--window", GetParam(), "--memory-limit", std::to_string(megabytes) + "M"});
  ASSERT_EQ(narrow.exit_code, 0) << narrow.errors;
  for (int64_t frame = 1; frame <= kFrames; ++frame) {
    EXPECT_TRUE(ReadText(FrameFileName(folder_ / "free/f.####.exr", frame)) ==
                ReadText(FrameFileName(folder_ / "narrow/f.####.exr", frame)))
        << frame;
  }
}

INSTANTIATE_TEST_SUITE_P(Windows, CliDenoiseMotion, ::testing::Values("past", "both"),
                         [](const auto& info) { return std::string(info.param); });

TEST(CliDenoiseMotionOwn, ZerosAreAViewThatStandsStill) {
  const TemporaryFolder folder;
  const ProgramRun rendered =
      RunProgram({"render", "builtin:cornell", "-o", folder / "in", "--size", "48x32", "--frames",
                  "1-3", "--still", "--save-inputs", "--format", "exr"});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.errors;
  const ProgramRun run =
      Denoise(folder / "in/noisy.####.exr", folder / "out", {"--json", folder / "log.json"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, Not(HasSubstr("motion is zero")));
  EXPECT_EQ(Json::parse(ReadText(folder / "log.json"))["frames"][2]["motion"], "file");
}

TEST(CliDenoiseMotionErrors, AreExplained) {
  const TemporaryFolder folder;
  const Shot shot;
  const std::string in = folder / "in.####.exr";
  WriteTexturedShot(in, shot, 3, Vectors::kNone);
  const std::string cameras = WriteCameras(folder, shot, 2);
  Json json = Json::parse(ReadText(cameras));
  const auto write = [&](const char* name) {
    const std::string text = json.dump();
    const std::string path = folder / name;
    EXPECT_TRUE(WriteFileAtomically(path, text.data(), text.size()).ok());
    return path;
  };
  const auto expect = [&](const std::vector<std::string>& options, const std::string& message) {
    const ProgramRun run = Denoise(in, folder / "out", options);
    EXPECT_EQ(run.exit_code, 2) << message;
    EXPECT_THAT(run.errors, HasSubstr(message));
  };
  expect({"--motion", "guess"}, "--motion: found 'guess', expected auto, file, camera or estimate");
  expect({"--motion", "camera"}, "has no camera, expected worldToCamera and worldToNDC");
  expect({"--cameras", folder / "absent.json"}, "absent.json");
  expect({"--cameras", cameras}, "has no camera of frame 3: it has 2 frames from 1 to 2");
  expect({"--cameras", cameras, "--motion", "file"}, "--cameras is given with --motion file");
  json["frames"].push_back(CameraOfShot(shot, 3));
  json["frames"][1]["type"] = "panoramic";
  expect({"--cameras", write("panorama.json"), "--motion", "camera"},
         "the camera of frame 2 in " + (folder / "panorama.json") + " has no projection");
  json["width"] = 64;
  expect({"--cameras", write("wide.json")},
         "wide.json has cameras of 64 x 24 pixels, the frames have 48 x 24");
  json["version"] = 2;
  expect({"--cameras", write("new.json")}, "new.json: version is 2, expected 1");
  expect({"--motion", "camera", "--cameras", WriteCameras(folder, shot, 3), "--aov", "depth=none"},
         "has no depth, expected a layer of depth");
  expect({"--motion", "estimate", "--aov", "albedo=none", "--aov", "depth=none"},
         "has neither albedo nor depth and normals");
}

// A panorama among perspective cameras: there motion is estimated.
TEST(CliDenoiseMotionErrors, APanoramaIsEstimated) {
  const TemporaryFolder folder;
  const Shot shot;
  const std::string in = folder / "in.####.exr";
  WriteTexturedShot(in, shot, 3, Vectors::kNone);
  Json json = Json::parse(ReadText(WriteCameras(folder, shot, 3)));
  json["frames"][1]["type"] = "panoramic";
  const std::string text = json.dump();
  ASSERT_TRUE(WriteFileAtomically(folder / "p.json", text.data(), text.size()).ok());
  const ProgramRun run = Denoise(in, folder / "out", {"--cameras", folder / "p.json"});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
}

}  // namespace
}  // namespace stillray::cli_denoise_motion_test
