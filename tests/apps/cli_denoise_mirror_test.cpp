// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise on frames of a room with a mirror, with Cycles' Denoising Data.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/mirror_room.h"
#include "program.h"
#include "stillray/io.h"

namespace stillray::cli_denoise_mirror_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr int kFrames = 12;

/// Moves to the right and forward.
RoomCamera CameraOf(int frame) {
  RoomCamera camera;
  camera.position += glm::dvec3(0.03, 0.005, 0.04) * static_cast<double>(frame);
  camera.pan = -0.1 - 0.004 * frame;
  return camera;
}

RoomPicture PictureOf(int frame) {
  return Trace(RoomWithMirror(), CameraOf(frame), CameraOf(frame - 1));
}

bool ShowsImage(const RoomPicture& picture, int x, int y) {
  return picture.expected.depth(x, y) > 0 && std::isfinite(picture.expected.depth(x, y));
}

/// Diffuse light is the albedo, and so is the light of what the mirror shows, times its colour.
Image3 Light(const RoomPicture& picture) {
  Image3 light = picture.frame.guides.albedo;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        light[c](x, y) +=
            picture.frame.guides.specular_albedo[c](x, y) * picture.expected.albedo[c](x, y);
      }
    }
  }
  return light;
}

/// All or nothing, of mean 1.
Image3 Noise(int frame, uint32_t seed) {
  std::mt19937 random(static_cast<uint32_t>(frame) * 7 + seed);
  Image3 noise(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float value = random() % 4 == 0 ? 4.0f : 0.0f;
      for (int c = 0; c < 3; ++c) {
        noise[c](x, y) = value;
      }
    }
  }
  return noise;
}

Image3 Product(const Image3& a, const Image3& b) {
  Image3 product(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        product[c](x, y) = a[c](x, y) * b[c](x, y);
      }
    }
  }
  return product;
}

/// Motion with y up.
void AddVector(const Image2& motion, ExrImage* image) {
  Image1 up(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      up(x, y) = -motion[1](x, y);
    }
  }
  image->Add("V.Vector.X", PixelType::kFloat, motion[0]);
  image->Add("V.Vector.Y", PixelType::kFloat, up);
}

ExrImage FileOf(const RoomPicture& picture, int frame) {
  const Guides& g = picture.frame.guides;
  ExrImage image;
  image.width = kWidth;
  image.height = kHeight;
  const Image3 none(kWidth, kHeight);
  image.Add("V.DiffDir.", PixelType::kFloat, Noise(frame, 1));
  image.Add("V.DiffInd.", PixelType::kFloat, none);
  image.Add("V.DiffCol.", PixelType::kFloat, g.albedo);
  image.Add("V.GlossDir.", PixelType::kFloat, none);
  image.Add("V.GlossInd.", PixelType::kFloat, Product(Noise(frame, 2), picture.expected.albedo));
  image.Add("V.GlossCol.", PixelType::kFloat, g.specular_albedo);
  image.Add("V.Depth.Z", PixelType::kFloat, g.depth);
  image.Add("V.Normal.", PixelType::kFloat, g.normal, true);
  AddVector(g.motion, &image);
  image.Add("V.Denoising Depth.Z", PixelType::kFloat, picture.seen.depth);
  image.Add("V.Denoising Normal.", PixelType::kFloat, picture.seen.normal, true);
  image.Add("V.Denoising Albedo.", PixelType::kHalf, picture.seen.albedo);
  return image;
}

/// Mean squared error of the denoised picture where the mirror shows an image.
double ErrorInMirror(const std::string& path, const RoomPicture& picture) {
  const Result<Image3> clean = ReadImage(path);
  if (!clean.ok()) {
    ADD_FAILURE() << clean.status().message();
    return 0;
  }
  const Image3 truth = Light(picture);
  double sum = 0;
  int count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (ShowsImage(picture, x, y)) {
        sum += std::pow((*clean)[1](x, y) - truth[1](x, y), 2);
        ++count;
      }
    }
  }
  EXPECT_GT(count, 1500);
  return sum / count;
}

TEST(CliDenoiseMirror, DenoisingDataKeepReflectionsSharp) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  for (int frame = 1; frame <= kFrames; ++frame) {
    ASSERT_TRUE(WriteExr(FrameFileName(in, frame), FileOf(PictureOf(frame), frame)).ok());
  }
  const auto denoise = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "denoise", in, "-o", folder / (out + ".####.exr"), "--device", "cpu", "--window", "past"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return run.output;
  };
  constexpr const char* kNote =
      "note: reflections in mirrors and what is seen through glass follow V.Denoising Depth";
  EXPECT_THAT(denoise("with", {}), HasSubstr(kNote));
  EXPECT_THAT(denoise("without", {"--aov", "seen_depth=none"}), Not(HasSubstr("refractions")));
  EXPECT_THAT(RunProgram({"info", FrameFileName(in, 1)}).output, HasSubstr(kNote));
  const RoomPicture last = PictureOf(kFrames);
  const double with = ErrorInMirror(FrameFileName(folder / "with.####.exr", kFrames), last);
  const double without = ErrorInMirror(FrameFileName(folder / "without.####.exr", kFrames), last);
  EXPECT_LT(with, 0.5 * without) << with << " " << without;
}

Image3 LayerOf(const ExrImage& image, const std::string& name) {
  const Result<Image3> layer = ExrLayer(image, "V." + name + ".");
  EXPECT_TRUE(layer.ok()) << layer.status().message();
  return layer.ok() ? *layer : Image3(kWidth, kHeight);
}

/// The light layers put together as Blender does it.
Image3 Composite(const ExrImage& image) {
  Image3 sum(kWidth, kHeight);
  for (const char* name : {"Diff", "Gloss"}) {
    const Image3 colour = LayerOf(image, std::string(name) + "Col");
    for (const char* bounces : {"Dir", "Ind"}) {
      const Image3 seen = Product(LayerOf(image, std::string(name) + bounces), colour);
      for (int c = 0; c < 3; ++c) {
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            sum[c](x, y) += seen[c](x, y);
          }
        }
      }
    }
  }
  return sum;
}

void Replace(const std::string& layer, const Image3& values, ExrImage* image) {
  std::erase_if(image->channels,
                [&](const Channel& channel) { return channel.name.starts_with(layer); });
  image->Add(layer, PixelType::kFloat, values);
}

// The reflected light is divided by the albedo of what the mirror shows too, and each layer must
// get it back.
TEST(CliDenoiseMirror, PassesAddUpToTheColour) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  for (int frame = 1; frame <= 4; ++frame) {
    const RoomPicture picture = PictureOf(frame);
    ExrImage file = FileOf(picture, frame);
    Replace("V.GlossDir.", Product(Noise(frame, 3), picture.expected.albedo), &file);
    Replace("V.Combined.", Composite(file), &file);
    ASSERT_TRUE(WriteExr(FrameFileName(in, frame), file).ok());
  }
  const RoomPicture third = PictureOf(3);
  for (const char* window : {"past", "both"}) {
    const std::string out = folder / (std::string(window) + ".####.exr");
    const ProgramRun run =
        RunProgram({"denoise", in, "-o", out, "--device", "cpu", "--passes", "--window", window});
    ASSERT_EQ(run.exit_code, 0) << run.errors;
    EXPECT_THAT(run.output, HasSubstr("note: reflections in mirrors"));
    const Result<ExrImage> image = ReadExr(FrameFileName(out, 3));
    ASSERT_TRUE(image.ok()) << image.status().message();
    const Image3 combined = LayerOf(*image, "Combined");
    const Image3 composite = Composite(*image);
    const Image3 parts[] = {LayerOf(*image, "GlossDir"), LayerOf(*image, "GlossInd")};
    double largest = 0;
    double seen[2] = {};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) {
          largest = std::max(largest, std::fabs(double{combined[c](x, y)} - composite[c](x, y)));
        }
        if (ShowsImage(third, x, y)) {
          seen[0] += parts[0][1](x, y);
          seen[1] += parts[1][1](x, y);
        }
      }
    }
    EXPECT_LT(largest, 1e-5) << window;
    EXPECT_NEAR(seen[0] / (seen[0] + seen[1]), 0.5, 0.05) << window;  // of the same mean
  }
}

}  // namespace
}  // namespace stillray::cli_denoise_mirror_test
