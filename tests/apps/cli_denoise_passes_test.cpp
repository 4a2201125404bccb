// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise --passes: every light layer denoised, and their sum the denoised colour.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_passes_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = Shot::kWidth;
constexpr int kHeight = Shot::kHeight;

/// A layer under noise of its own with the mean `truth`.
Image3 NoisyImage(float truth, int64_t seed) {
  Image3 image(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        image[c](x, y) = 2 * truth * ShotNoise(x, y, seed * 7 + c);
      }
    }
  }
  return image;
}

void AddProduct(const Image3& a, const Image3& b, Image3* sum) {
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        (*sum)[c](x, y) += a[c](x, y) * b[c](x, y);
      }
    }
  }
}

struct PassTruth {
  const char* name;
  const char* colour;  ///< the layer that it is without, or nullptr
  float light;
};
constexpr PassTruth kPasses[] = {
    {"DiffDir", "DiffCol", 1.0f},   {"DiffInd", "DiffCol", 0.5f},   {"GlossDir", "GlossCol", 0.25f},
    {"GlossInd", "GlossCol", 2.0f}, {"TransDir", "TransCol", 0.1f}, {"TransInd", "TransCol", 0.4f},
    {"VolumeDir", nullptr, 0.2f},   {"VolumeInd", nullptr, 0.3f},
};

/// A wall with all of Blender's passes. Under noise it is black in its left third, clear in its
/// right half.
ExrImage AllPasses(int64_t frame, bool noisy) {
  ExrImage image = ShotFrame({.speed = 0}, frame);
  const auto replace = [&](const std::string& layer, const Image3& values) {
    std::erase_if(image.channels, [&](const Channel& channel) {
      return channel.name.starts_with("ViewLayer." + layer + ".");
    });
    image.Add("ViewLayer." + layer + ".", PixelType::kFloat, values);
  };
  Image3 colours[3] = {ConstantImage(0.5f, 0.4f, 0), ConstantImage(1, 0.8f, 0.005f),
                       ConstantImage(0, 0.25f, 0.5f)};
  for (int y = 0; y < kHeight && noisy; ++y) {
    for (int c = 0; c < 3; ++c) {
      std::fill_n(colours[0][c].Row(y), kWidth / 3, 0.0f);
      std::fill_n(colours[2][c].Row(y), kWidth / 2, 0.0f);
    }
  }
  Image3 combined = ConstantImage(0.125f, 0, 0.25f);
  const Image3 one = ConstantImage(1, 1, 1);
  for (int i = 0; i < 8; ++i) {
    const PassTruth& pass = kPasses[i];
    const Image3& colour = i < 6 ? colours[i / 2] : one;
    Image3 light = noisy ? NoisyImage(pass.light, 100 * frame + i)
                         : ConstantImage(pass.light, pass.light, pass.light);
    // Where nothing is reflected there is no light.
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          light[c](x, y) = colour[c](x, y) > 0 ? light[c](x, y) : 0.0f;
        }
      }
    }
    AddProduct(light, colour, &combined);
    replace(pass.name, light);
  }
  replace("DiffCol", colours[0]);
  replace("GlossCol", colours[1]);
  replace("TransCol", colours[2]);
  replace("Emit", ConstantImage(0.125f, 0, 0));
  replace("Env", ConstantImage(0, 0, 0.25f));
  replace("Combined", combined);
  return image;
}

Image3 Layer(const ExrImage& image, const std::string& name) {
  const Result<Image3> layer = ExrLayer(image, name.empty() ? "" : "ViewLayer." + name + ".");
  if (!layer.ok()) {
    ADD_FAILURE() << layer.status().message();
    return ConstantImage(0, 0, 0);
  }
  return *layer;
}

/// The layers put together as Blender does it.
Image3 Composite(const ExrImage& image) {
  Image3 sum = Layer(image, "Emit");
  const Image3 one = ConstantImage(1, 1, 1);
  AddProduct(Layer(image, "Env"), one, &sum);
  for (const PassTruth& pass : kPasses) {
    AddProduct(Layer(image, pass.name), pass.colour != nullptr ? Layer(image, pass.colour) : one,
               &sum);
  }
  return sum;
}

double LargestDifference(const Image3& a, const Image3& b) {
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        largest = std::max(largest, std::fabs(double{a[c](x, y)} - b[c](x, y)));
      }
    }
  }
  return largest;
}

/// Mean squared relative difference of a layer from its true light, where its colour is not black.
double LayerError(const ExrImage& image, const PassTruth& pass) {
  const Image3 light = Layer(image, pass.name);
  const Image3 colour = pass.colour != nullptr ? Layer(image, pass.colour) : ConstantImage(1, 1, 1);
  double sum = 0;
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (colour[1](x, y) > 0) {
        sum += std::pow(light[1](x, y) / double{pass.light} - 1, 2);
        ++count;
      }
    }
  }
  return sum / count;
}

ExrImage DenoiseShot(const TemporaryFolder& folder, bool noisy, const std::string& window,
                     const std::string& preset = "default") {
  for (int64_t frame = 1; frame <= 4; ++frame) {
    const Status written =
        WriteExr(FrameFileName(folder / "in.#.exr", frame), AllPasses(frame, noisy));
    EXPECT_TRUE(written.ok()) << written.message();
  }
  const ProgramRun run = RunProgram({"denoise", folder / "in.#.exr", "-o", folder / "out.#.exr",
                                     "--passes", "--window", window, "--preset", preset});
  EXPECT_EQ(run.exit_code, 0) << run.errors;
  const Result<ExrImage> out = ReadExr(folder / "out.3.exr");
  return out.ok() ? *out : AllPasses(0, false);
}

TEST(CliDenoisePasses, LayersAddUpToTheColourAndAreCleanOnTheirOwn) {
  for (const auto& [window, preset] :
       {std::pair{"past", "default"}, {"both", "default"}, {"past", "best"}}) {
    const TemporaryFolder folder;
    const ExrImage out = DenoiseShot(folder, true, window, preset);
    EXPECT_LT(LargestDifference(Composite(out), Layer(out, "Combined")), 2e-6);
    const ExrImage in = AllPasses(3, true);
    for (const PassTruth& pass : kPasses) {
      EXPECT_LT(LayerError(out, pass), 0.1 * LayerError(in, pass)) << pass.name;
    }
    EXPECT_EQ(LargestDifference(Layer(out, "DiffCol"), Layer(in, "DiffCol")), 0);
  }
}

TEST(CliDenoisePasses, LightWithoutNoiseStaysInItsLayer) {
  const TemporaryFolder folder;
  const ExrImage out = DenoiseShot(folder, false, "past");
  for (const PassTruth& pass : kPasses) {
    EXPECT_LT(LayerError(out, pass), 1e-9) << pass.name;
  }
  const ExrImage in = AllPasses(3, false);
  EXPECT_LT(LargestDifference(Layer(out, "Combined"), Layer(in, "Combined")), 4e-6);
}

// Without --passes nothing of this changes: the colour differs by the light that the albedo's floor
// leaves on black surfaces, and nowhere else.
TEST(CliDenoisePasses, ColourIsTheSameAsWithoutThem) {
  const TemporaryFolder folder;
  const ExrImage with = DenoiseShot(folder, true, "past");
  const ProgramRun run = RunProgram(
      {"denoise", folder / "in.#.exr", "-o", folder / "plain.#.exr", "--window", "past"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  const Result<ExrImage> plain = ReadExr(folder / "plain.3.exr");
  ASSERT_TRUE(plain.ok());
  const Image3 a = Layer(with, "Combined");
  const Image3 b = Layer(*plain, "Combined");
  for (int y = 0; y < kHeight; ++y) {
    // Green is black nowhere in the right half.
    EXPECT_EQ(a[1](kWidth - 5, y), b[1](kWidth - 5, y));
  }
  EXPECT_LT(LargestDifference(a, b), 0.03);
  EXPECT_EQ(LargestDifference(Layer(*plain, "GlossDir"), Layer(AllPasses(3, true), "GlossDir")), 0);
}

// Layers with their colour in them, and light that no layer names.
TEST(CliDenoisePasses, ArnoldLayersKeepTheirColour) {
  const TemporaryFolder folder;
  for (int64_t frame = 1; frame <= 3; ++frame) {
    ExrImage image = ShotFrame({.speed = 0}, frame);
    image.channels.clear();
    Image3 sum = ConstantImage(0, 0, 0);
    const Image3 one = ConstantImage(1, 1, 1);
    int64_t seed = 10 * frame;
    for (const char* name :
         {"diffuse_direct", "diffuse_indirect", "specular_direct", "specular_indirect", "coat"}) {
      const Image3 light = NoisyImage(0.5f, ++seed);
      AddProduct(light, one, &sum);
      if (std::string(name) != "coat") {
        image.Add(std::string(name) + ".", PixelType::kFloat, light);
      }
    }
    image.Add("", PixelType::kFloat, sum);
    image.Add("diffuse_albedo.", PixelType::kFloat, ConstantImage(0.5f, 0.5f, 0.5f));
    image.Add("Z", PixelType::kFloat, ConstantPlane(4));
    image.Add("N.", PixelType::kFloat, ConstantImage(0, 0, 1), true);
    image.Add("motionvector.", PixelType::kFloat, ConstantImage(0, 0, 0));
    ASSERT_TRUE(WriteExr(FrameFileName(folder / "in.#.exr", frame), image).ok());
  }
  const ProgramRun run = RunProgram(
      {"denoise", folder / "in.#.exr", "-o", folder / "out.#.exr", "--passes", "--timings"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("understood as frames of arnold"));
  const Result<ExrImage> out = ReadExr(folder / "out.3.exr");
  ASSERT_TRUE(out.ok());
  const Image3 colour = Layer(*out, "");
  for (const char* name :
       {"diffuse_direct", "diffuse_indirect", "specular_direct", "specular_indirect"}) {
    const Result<Image3> layer = ExrLayer(*out, std::string(name) + ".");
    ASSERT_TRUE(layer.ok());
    double sum = 0;
    double squares = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        sum += (*layer)[0](x, y) - 0.5;
        squares += std::pow((*layer)[0](x, y) - 0.5, 2);
      }
    }
    EXPECT_LT(std::fabs(sum / (kWidth * kHeight)), 0.03) << name;
    EXPECT_LT(squares / (kWidth * kHeight), 0.005) << name;  // noise has 0.083
  }
  double rest = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      rest += (colour[0](x, y) - 2.0) / (kWidth * kHeight);
    }
  }
  EXPECT_NEAR(rest, 0.5, 0.05);  // the coat is in the colour alone
}

TEST(CliDenoisePasses, GoesOnWithTheSameBits) {
  const TemporaryFolder folder;
  for (int64_t frame = 1; frame <= 6; ++frame) {
    ASSERT_TRUE(WriteExr(FrameFileName(folder / "in.#.exr", frame), AllPasses(frame, true)).ok());
  }
  const auto denoise = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "denoise",  folder / "in.#.exr", "-o",  folder / (out + "/f.#.exr"),
        "--passes", "--window",          "past"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  };
  ASSERT_EQ(denoise("whole", {}).exit_code, 0);
  const std::string bytes = ReadText(folder / "in.4.exr");
  ASSERT_TRUE(WriteFileAtomically(folder / "in.4.exr", bytes.data(), bytes.size() / 2).ok());
  EXPECT_EQ(denoise("part", {}).exit_code, 2);
  ASSERT_TRUE(WriteFileAtomically(folder / "in.4.exr", bytes.data(), bytes.size()).ok());
  const ProgramRun resumed = denoise("part", {"--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame 4"));
  for (int64_t frame = 1; frame <= 6; ++frame) {
    EXPECT_EQ(ReadText(FrameFileName(folder / "whole/f.#.exr", frame)),
              ReadText(FrameFileName(folder / "part/f.#.exr", frame)))
        << frame;
  }
}

// The layers of frames that are in the history and not on disk are in the state.
TEST(CliDenoisePasses, APictureThatCannotBeWrittenKeepsItsLayers) {
  const TemporaryFolder folder;
  for (int64_t frame = 1; frame <= 5; ++frame) {
    ASSERT_TRUE(WriteExr(FrameFileName(folder / "in.#.exr", frame), AllPasses(frame, true)).ok());
  }
  const auto denoise = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "denoise",  folder / "in.#.exr", "-o", folder / (out + "/f.#.exr"),
        "--passes", "--threads",         "2"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  };
  ASSERT_EQ(denoise("whole", {}).exit_code, 0);
  std::filesystem::create_directories(folder / "part/f.3.exr/in_the_way");
  EXPECT_EQ(denoise("part", {}).exit_code, 2);
  std::filesystem::remove_all(folder / "part/f.3.exr");
  const ProgramRun resumed = denoise("part", {"--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors, HasSubstr("resuming with frame 3"));
  for (int64_t frame = 1; frame <= 5; ++frame) {
    EXPECT_EQ(ReadText(FrameFileName(folder / "whole/f.#.exr", frame)),
              ReadText(FrameFileName(folder / "part/f.#.exr", frame)))
        << frame;
  }
}

TEST(CliDenoisePasses, WhatCannotBeToldApartIsRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteExr(folder / "in.1.exr", AllPasses(1, true)).ok());
  const auto error = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"denoise", folder / "in.#.exr", "-o",
                                          folder / "out.#.exr", "--passes"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.errors;
    return run.errors;
  };
  EXPECT_THAT(error({"--set", "signals=single"}),
              HasSubstr("--passes: signals is single, expected split"));
  EXPECT_THAT(error({"--set", "demodulate=off"}), HasSubstr("demodulate is off, expected on"));
  EXPECT_THAT(error({"--set", "antialias=taa"}), HasSubstr("antialias is taa, expected off"));
  EXPECT_THAT(error({"--aov", "direct_diffuse=none", "--aov", "indirect_diffuse=none"}),
              HasSubstr("the files have no light passes"));
}

}  // namespace
}  // namespace stillray::cli_denoise_passes_test
