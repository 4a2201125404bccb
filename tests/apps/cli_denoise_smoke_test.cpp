// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise of smoke: light that a volume scatters before a wall, or before nothing, and
// alpha.
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_smoke_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = Shot::kWidth;
constexpr int kHeight = Shot::kHeight;
constexpr float kPasses = 0.5f;  // part of the samples that pass the smoke
constexpr float kSmoke = 0.8f;   // light of one that does not
constexpr float kSky = 0.3f;     // and of a sky behind it

struct Smoke {
  bool wall = true;  ///< behind it, else a transparent film
  int samples = 1;
  bool sky = false;  ///< in place of the film
};

/// Layers as Cycles writes them: means over the samples, but the depth of the first one.
ExrImage SmokeFrame(const Smoke& smoke, int64_t frame) {
  ExrImage image = ShotFrame({.speed = 0, .noisy = false, .contrast = 0}, frame);
  Image1 hits(kWidth, kHeight);
  Image1 depth(kWidth, kHeight);
  depth.Fill(1e10f);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int s = 0; s < smoke.samples; ++s) {
        if (ShotNoise(x, y, 100 * frame + s) < kPasses) {
          hits(x, y) += 1 / static_cast<float>(smoke.samples);
          if (s == 0 && smoke.wall) {
            depth(x, y) = 4;
          }
        }
      }
    }
  }
  const auto scaled = [&](float offset, float factor) {
    Image1 plane(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        plane(x, y) = offset + factor * hits(x, y);
      }
    }
    return plane;
  };
  const auto replace = [&](const std::string& channel, const Image1& values) {
    std::erase_if(image.channels,
                  [&](const Channel& c) { return c.name == "ViewLayer." + channel; });
    image.Add("ViewLayer." + channel, PixelType::kFloat, values);
  };
  const float wall = smoke.wall ? 1.0f : 0.0f;
  for (const char* c : {"R", "G", "B"}) {
    replace(std::string("DiffCol.") + c, scaled(0, wall * Shot::kColour));
    replace(std::string("DiffDir.") + c, ConstantPlane(wall));
    replace(std::string("VolumeDir.") + c, scaled(kSmoke, -kSmoke));
    const float behind = smoke.sky ? kSky : wall * Shot::kColour;
    replace(std::string("Combined.") + c, scaled(kSmoke, behind - kSmoke));
    if (smoke.sky) {
      replace(std::string("Env.") + c, scaled(0, kSky));
    }
  }
  replace("Combined.A", smoke.wall || smoke.sky ? ConstantPlane(1) : scaled(1, -1));
  replace("Normal.Z", scaled(0, wall));
  replace("Depth.Z", depth);
  return image;
}

struct Error {
  double bias = 0;     ///< of the mean
  double squared = 0;  ///< mean squared
};

Error ErrorOf(const Image1& plane, float truth) {
  Error error;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      error.bias += (plane(x, y) - truth) / (kWidth * kHeight);
      error.squared += std::pow(plane(x, y) - truth, 2) / (kWidth * kHeight);
    }
  }
  return error;
}

void WriteSmoke(const std::string& pattern, const Smoke& smoke, int64_t frames) {
  for (int64_t frame = 1; frame <= frames; ++frame) {
    ASSERT_TRUE(WriteExr(FrameFileName(pattern, frame), SmokeFrame(smoke, frame)).ok());
  }
}

Image1 Channel1(const std::string& file, const std::string& channel) {
  const Result<ExrImage> image = ReadExr(file);
  if (!image.ok() || image->Find("ViewLayer." + channel) == nullptr) {
    ADD_FAILURE() << file << ": no " << channel;
    return ConstantPlane(0);
  }
  return image->Find("ViewLayer." + channel)->values;
}

TEST(CliDenoiseSmoke, NoiseOfRandomHitsIsFiltered) {
  for (const Smoke& smoke : {Smoke{true, 1}, Smoke{true, 4}, Smoke{false, 1}, Smoke{false, 4}}) {
    const TemporaryFolder folder;
    WriteSmoke(folder / "in.##.exr", smoke, 10);
    const ProgramRun run = RunProgram({"denoise", folder / "in.##.exr", "-o", folder / "out.##.exr",
                                       "--set", "antialias=off", "--window", "past"});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    const float truth = (1 - kPasses) * kSmoke + (smoke.wall ? kPasses * Shot::kColour : 0.0f);
    const Error before = ErrorOf(Channel1(folder / "in.10.exr", "Combined.G"), truth);
    const Error after = ErrorOf(Channel1(folder / "out.10.exr", "Combined.G"), truth);
    EXPECT_LT(after.squared, 0.05 * before.squared) << smoke.wall << " " << smoke.samples;
    EXPECT_LT(std::fabs(after.bias), 0.03 * truth) << smoke.wall << " " << smoke.samples;
  }
}

TEST(CliDenoiseSmoke, PassesOfTheSkyBehindItAreFilteredToo) {
  const TemporaryFolder folder;
  WriteSmoke(folder / "in.##.exr", {false, 4, true}, 10);
  const ProgramRun run = RunProgram({"denoise", folder / "in.##.exr", "-o", folder / "out.##.exr",
                                     "--passes", "--set", "antialias=off", "--window", "past"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const auto expect_clean = [&](const std::string& channel, float truth) {
    const Error before = ErrorOf(Channel1(folder / "in.10.exr", channel), truth);
    const Error after = ErrorOf(Channel1(folder / "out.10.exr", channel), truth);
    EXPECT_LT(after.squared, 0.1 * before.squared) << channel;
    EXPECT_LT(std::fabs(after.bias), 0.03 * truth) << channel;
  };
  expect_clean("Combined.G", (1 - kPasses) * kSmoke + kPasses * kSky);
  expect_clean("VolumeDir.G", (1 - kPasses) * kSmoke);
  expect_clean("Env.G", kPasses * kSky);
  const Image1 whole = Channel1(folder / "out.10.exr", "Combined.G");
  const Image1 volume = Channel1(folder / "out.10.exr", "VolumeDir.G");
  const Image1 sky = Channel1(folder / "out.10.exr", "Env.G");
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_NEAR(volume(x, y) + sky(x, y), whole(x, y), 2e-3) << x << " " << y;
    }
  }
}

TEST(CliDenoiseSmoke, AlphaIsCopiedUnlessItIsDenoised) {
  const TemporaryFolder folder;
  WriteSmoke(folder / "in.##.exr", {false, 2}, 10);
  for (const char* window : {"past", "both"}) {
    const auto denoise = [&](const std::string& out, const std::vector<std::string>& more) {
      std::vector<std::string> arguments = {"denoise",    folder / "in.##.exr", "-o",
                                            folder / out, "--window",           window};
      arguments.insert(arguments.end(), more.begin(), more.end());
      const ProgramRun run = RunProgram(arguments);
      EXPECT_EQ(run.exit_code, 0) << run.errors;
    };
    denoise("keep.##.exr", {});
    denoise("clean.##.exr", {"--alpha", "denoise"});
    const Image1 in = Channel1(folder / "in.10.exr", "Combined.A");
    const Image1 keep = Channel1(folder / "keep.10.exr", "Combined.A");
    const Image1 clean = Channel1(folder / "clean.10.exr", "Combined.A");
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        EXPECT_EQ(in(x, y), keep(x, y));
      }
    }
    const Error before = ErrorOf(in, 1 - kPasses);
    const Error after = ErrorOf(clean, 1 - kPasses);
    EXPECT_LT(after.squared, 0.05 * before.squared);
    EXPECT_LT(std::fabs(after.bias), 0.01);
    const Image1 a = Channel1(folder / "keep.10.exr", "Combined.R");
    const Image1 b = Channel1(folder / "clean.10.exr", "Combined.R");
    EXPECT_EQ(a(7, 7), b(7, 7)) << "the light is the same";
  }
}

TEST(CliDenoiseSmoke, AlphaOfLaterFramesHelpsTheFirst) {
  const TemporaryFolder folder;
  WriteSmoke(folder / "in.##.exr", {false, 2}, 8);
  const auto squared_error = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "denoise", folder / "in.##.exr", "-o", folder / out, "--alpha", "denoise", "--window"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return ErrorOf(Channel1(FrameFileName(folder / out, 1), "Combined.A"), 1 - kPasses).squared;
  };
  // Few levels, for which the first frame alone is not enough.
  const double past = squared_error("past.##.exr", {"past", "--set", "steps=1,2"});
  EXPECT_LT(squared_error("both.##.exr", {"both", "--set", "steps=1,2"}), 0.6 * past);
  squared_error("one.##.exr", {"both", "--set", "steps=1,2", "--memory-limit", "6M"});
  EXPECT_EQ(ReadText(folder / "both.01.exr"), ReadText(folder / "one.01.exr"))
      << "how many futures are held at once changes no bits";
}

TEST(CliDenoiseSmoke, AResumedRunHasTheSameAlpha) {
  const TemporaryFolder folder;
  WriteSmoke(folder / "in.##.exr", {false, 1}, 6);
  const auto denoise = [&](const std::string& out, const std::vector<std::string>& more,
                           const std::string& alpha = "denoise") {
    std::vector<std::string> arguments = {
        "denoise",  folder / "in.##.exr", "-o",  folder / (out + "/f.##.exr"), "--alpha", alpha,
        "--passes", "--window",           "past"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  };
  ASSERT_EQ(denoise("whole", {}).exit_code, 0);
  const std::string bytes = ReadText(folder / "in.04.exr");
  ASSERT_TRUE(WriteFileAtomically(folder / "in.04.exr", bytes.data(), bytes.size() / 2).ok());
  EXPECT_EQ(denoise("part", {}).exit_code, 2);
  const ProgramRun other = denoise("part", {"--resume"}, "keep");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.errors, HasSubstr("alpha"));
  ASSERT_TRUE(WriteFileAtomically(folder / "in.04.exr", bytes.data(), bytes.size()).ok());
  const ProgramRun resumed = denoise("part", {"--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame 4"));
  for (int64_t frame = 1; frame <= 6; ++frame) {
    EXPECT_EQ(ReadText(FrameFileName(folder / "whole/f.##.exr", frame)),
              ReadText(FrameFileName(folder / "part/f.##.exr", frame)))
        << frame;
  }
}

TEST(CliDenoiseSmoke, AlphaThatCannotBeFilteredIsNamed) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteExr(folder / "in.1.exr", ShotFrame({}, 1)).ok());
  const auto error = [&](const std::string& alpha) {
    const ProgramRun run =
        RunProgram({"denoise", folder / "in.#.exr", "-o", folder / "out.#.exr", "--alpha", alpha});
    EXPECT_EQ(run.exit_code, 2) << run.errors;
    return run.errors;
  };
  EXPECT_THAT(error("denoise"), HasSubstr("in.1.exr has no alpha"));
  EXPECT_THAT(error("clean"), HasSubstr("denoise"));
  ExrImage image = ShotFrame({}, 1);
  Plane<uint32_t> integers(kWidth, kHeight);
  integers.Fill(1);
  image.Add("ViewLayer.Combined.A", integers);
  ASSERT_TRUE(WriteExr(folder / "in.1.exr", image).ok());
  EXPECT_THAT(error("denoise"), HasSubstr("ViewLayer.Combined.A of"));
}

}  // namespace
}  // namespace stillray::cli_denoise_smoke_test
