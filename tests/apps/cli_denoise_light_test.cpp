// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise on files whose light needs a decision: the colour alone, a colour that is clean
// already, several view layers.
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_light_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

ProgramRun Denoise(const std::string& in, const std::string& out,
                   const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"denoise", in, "-o", out, "--device", "cpu"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunProgram(arguments);
}

Channel& ChannelOf(ExrImage& image, const std::string& name) {
  for (Channel& channel : image.channels) {
    if (channel.name == name) {
      return channel;
    }
  }
  ADD_FAILURE() << "no channel " << name;
  return image.channels.front();
}

const Image1& Green(const ExrImage& image, const std::string& layer = "ViewLayer.Combined") {
  return image.Find(layer + ".G")->values;
}

double Mean(const Image1& plane) {
  double sum = 0;
  for (int y = 0; y < plane.height(); ++y) {
    for (int x = 0; x < plane.width(); ++x) {
      sum += plane(x, y);
    }
  }
  return sum / (static_cast<double>(plane.width()) * plane.height());
}

TEST(CliDenoiseLight, AColourThatIsCleanAlreadyGivesThePictureOfThePasses) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  Shot clean;
  clean.noisy = false;
  for (int64_t frame = 1; frame <= 4; ++frame) {
    ExrImage image = ShotFrame(Shot(), frame);
    const ExrImage truth = ShotFrame(clean, frame);
    for (const char* letter : {"R", "G", "B"}) {
      const std::string name = std::string("ViewLayer.Combined.") + letter;
      ChannelOf(image, name).values = truth.Find(name)->values;
    }
    ASSERT_TRUE(WriteExr(FrameFileName(in, frame), image).ok());
  }
  const ProgramRun run = Denoise(in, folder / "auto.####.exr");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("ViewLayer.Combined lacks"));
  ASSERT_EQ(Denoise(in, folder / "none.####.exr", {"--aov", "colour=none"}).exit_code, 0);
  for (int64_t frame = 1; frame <= 4; ++frame) {
    const Result<ExrImage> a = ReadExr(FrameFileName(folder / "auto.####.exr", frame));
    const Result<ExrImage> b = ReadExr(FrameFileName(folder / "none.####.exr", frame));
    ASSERT_TRUE(a.ok() && b.ok());
    for (int y = 0; y < Shot::kHeight; ++y) {
      for (int x = 0; x < Shot::kWidth; ++x) {
        ASSERT_EQ(Green(*a)(x, y), Green(*b)(x, y)) << frame << " " << x << " " << y;
      }
    }
  }
  // Clean passes beside the clean colour are nothing to speak of.
  WriteShot(folder / "clean.####.exr", clean, 1, 2);
  EXPECT_THAT(Denoise(folder / "clean.####.exr", folder / "c.####.exr").output,
              Not(HasSubstr("lacks")));
}

bool IsGlass(int x, int y) {
  return x >= 12 && x < 36 && y >= 6 && y < 18;
}

/// The layers of *Combined, Z, Vector, Normal, Denoising Data* for a wall behind glass: there the
/// denoising layers are those of a random surface behind it, including lamps and sky (black).
ExrImage FrameWithDenoisingData(const Shot& shot, int64_t frame) {
  ExrImage image = ShotFrame(shot, frame);
  std::erase_if(image.channels,
                [](const Channel& c) { return c.name.starts_with("ViewLayer.Diff"); });
  Image3 albedo = ConstantImage(shot.colour, shot.colour, shot.colour);
  Image3 normal = ConstantImage(0, 0, -1);  // of the wall, in the camera's axes
  for (int y = 0; y < Shot::kHeight; ++y) {
    for (int x = 0; x < Shot::kWidth; ++x) {
      if (!IsGlass(x, y)) {
        continue;
      }
      const float chance = ShotNoise(x, y, frame + 1000);
      for (int c = 0; c < 3; ++c) {
        albedo[c](x, y) = chance < 0.2f ? 0.0f : chance;
        normal[c](x, y) = c == (chance < 0.5f ? 0 : 1) ? 1.0f : 0.0f;
      }
    }
  }
  image.Add("ViewLayer.Denoising Albedo.", PixelType::kHalf, albedo);
  image.Add("ViewLayer.Denoising Normal.", PixelType::kHalf, normal, true);
  return image;
}

TEST(CliDenoiseLight, DenoisingDataKeepTheBrightnessOfGlass) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  Shot shot;
  shot.speed = 0;
  shot.contrast = 0;
  constexpr int64_t kLast = 8;
  double noisy_mean = 0;
  for (int64_t frame = 1; frame <= kLast; ++frame) {
    const ExrImage image = FrameWithDenoisingData(shot, frame);
    noisy_mean += Mean(Green(image)) / kLast;
    ASSERT_TRUE(WriteExr(FrameFileName(in, frame), image).ok());
  }
  const ProgramRun run = Denoise(in, folder / "out.####.exr");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("divided by ViewLayer.Denoising Albedo where that is not"));
  const Result<ExrImage> out = ReadExr(FrameFileName(folder / "out.####.exr", kLast));
  ASSERT_TRUE(out.ok());
  EXPECT_NEAR(Mean(Green(*out)) / noisy_mean, 1, 0.02);
  double noise = 0;
  double left = 0;
  const ExrImage last = FrameWithDenoisingData(shot, kLast);
  for (int y = 0; y < Shot::kHeight; ++y) {
    for (int x = 0; x < Shot::kWidth; ++x) {
      if (IsGlass(x, y)) {
        noise += std::pow(Green(last)(x, y) - shot.colour, 2);
        left += std::pow(Green(*out)(x, y) - shot.colour, 2);
      }
    }
  }
  EXPECT_LT(left, 0.05 * noise);
}

TEST(CliDenoiseLight, AnotherViewLayerIsChosenByName) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  for (int64_t frame = 1; frame <= 3; ++frame) {
    ExrImage image = ShotFrame(Shot(), frame);
    const std::vector<Channel> channels = image.channels;
    for (Channel channel : channels) {
      channel.name = "Only Ball" + channel.name.substr(channel.name.find('.'));
      image.channels.push_back(std::move(channel));
    }
    ASSERT_TRUE(WriteExr(FrameFileName(in, frame), image).ok());
  }
  ProgramRun run = Denoise(in, folder / "a.####.exr");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("--view-layer NAME denoises another one"));
  run = Denoise(in, folder / "b.####.exr", {"--view-layer", "ViewLayer"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const Result<ExrImage> noisy = ReadExr(FrameFileName(in, 3));
  const Result<ExrImage> b = ReadExr(folder / "b.0003.exr");
  ASSERT_TRUE(noisy.ok() && b.ok());
  EXPECT_EQ(Green(*b, "Only Ball.Combined")(5, 5), Green(*noisy, "Only Ball.Combined")(5, 5));
  EXPECT_NE(Green(*b)(5, 5), Green(*noisy)(5, 5));
  run = Denoise(in, folder / "c.####.exr", {"--view-layer", "ball"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("--view-layer is 'ball', expected one of"));
}

TEST(CliDenoiseLight, AFrameOfAnotherSizeIsNamedBySize) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShot(in, Shot(), 1, 2);
  ExrImage image = ShotFrame(Shot(), 3);
  for (Channel& channel : image.channels) {
    channel.values = Image1(32, 16);
    channel.values.Fill(1);
  }
  image.width = 32;
  image.height = 16;
  ASSERT_TRUE(WriteExr(folder / "in.0003.exr", image).ok());
  const ProgramRun run = Denoise(in, folder / "out.####.exr");
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.errors, HasSubstr("frame 3: 32 x 16 pixels in place of 48 x 24; the history"));
}

}  // namespace
}  // namespace stillray::cli_denoise_light_test
