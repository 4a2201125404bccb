// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames of Blender whose pixels have different numbers of samples, from the file to the picture.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "apps/cli_denoise_shot.h"
#include "stillray/aov.h"
#include "stillray/denoise.hpp"

namespace stillray::sample_counts_test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr int kMost = 64;
constexpr int kFrames = 6;

/// Light on a wall, which changes slowly.
float Truth(int x, int y) {
  return 1.0f +
         0.5f * std::sin(0.1f * static_cast<float>(x)) * std::cos(0.08f * static_cast<float>(y));
}

/// In blocks whose counts change from frame to frame.
int Count(int x, int y, int frame, bool adaptive) {
  constexpr int kCounts[] = {2, 8, 32, kMost};
  const float block = ShotNoise(x / 8, y / 8, frame + 100);
  return adaptive ? kCounts[static_cast<int>(block * 4) % 4] : kMost;
}

/// The mean of that many exponentially distributed samples.
float NoisyLight(int x, int y, int frame, int count) {
  float sum = 0;
  for (int i = 0; i < count; ++i) {
    sum -= std::log(1.0f - ShotNoise(x, y, int64_t{frame} * kMost + i + 1000));
  }
  return Truth(x, y) * sum / static_cast<float>(count);
}

ExrImage FileOf(int frame, bool adaptive) {
  ExrImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.attributes["cycles.V.samples"] = std::to_string(kMost);
  Image1 light(kWidth, kHeight);
  Image1 fractions(kWidth, kHeight);
  Image1 counts(kWidth, kHeight);
  Image1 one(kWidth, kHeight);
  one.Fill(1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int count = Count(x, y, frame, adaptive);
      light(x, y) = NoisyLight(x, y, frame, count);
      fractions(x, y) = static_cast<float>(count) / kMost;
      counts(x, y) = static_cast<float>(count);
    }
  }
  for (const char* layer : {"V.Combined", "V.DiffDir", "V.DiffInd", "V.DiffCol"}) {
    for (const char* letter : {".R", ".G", ".B"}) {
      const bool dark = std::string(layer) == "V.DiffInd";
      const bool white = std::string(layer) == "V.DiffCol";
      image.Add(std::string(layer) + letter, PixelType::kFloat,
                dark ? Image1(kWidth, kHeight) : (white ? one : light));
    }
  }
  image.Add("V.Depth.Z", PixelType::kFloat, one);
  image.Add("V.Normal.X", PixelType::kFloat, Image1(kWidth, kHeight));
  image.Add("V.Normal.Y", PixelType::kFloat, Image1(kWidth, kHeight));
  image.Add("V.Normal.Z", PixelType::kFloat, one);
  for (const char* letter : {"X", "Y", "Z", "W"}) {
    image.Add(std::string("V.Vector.") + letter, PixelType::kFloat, Image1(kWidth, kHeight));
  }
  image.Add("V.Debug Sample Count.X", PixelType::kFloat, fractions);
  image.Add("V.Counts.X", PixelType::kFloat, counts);
  Image1 same(kWidth, kHeight);
  same.Fill(26);  // the mean of kCounts
  image.Add("V.Same.X", PixelType::kFloat, same);
  return image;
}

/// The last of some frames.
Image3 Denoised(bool adaptive, const std::vector<std::string>& mappings) {
  Result<Denoiser> denoiser = Denoiser::Create(PresetSettings("default").value());
  EXPECT_TRUE(denoiser.ok());
  DenoisedFrame denoised;
  for (int frame = 1; frame <= kFrames; ++frame) {
    const ExrImage image = FileOf(frame, adaptive);
    const Result<AovLayout> layout = UnderstandAovs(image, {"auto", mappings}, "file");
    EXPECT_TRUE(layout.ok()) << layout.status().message();
    Result<Frame> imported = ImportFrame(image, *layout, {0, 0}, "file");
    EXPECT_TRUE(imported.ok()) << imported.status().message();
    imported->index = frame;
    const Status status = denoiser->Denoise(*imported, &denoised);
    EXPECT_TRUE(status.ok()) << status.message();
  }
  return denoised.colour;
}

double MeanSquare(const Image3& colour) {
  double sum = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double d = double{colour[1](x, y)} - Truth(x, y);
      sum += d * d;
    }
  }
  return sum / (kWidth * kHeight);
}

TEST(SampleCounts, PixelsOfMoreSamplesCountForMore) {
  const double with = MeanSquare(Denoised(true, {}));
  const double without = MeanSquare(Denoised(true, {"samples=Same"}));
  EXPECT_LT(with, 0.7 * without) << with << " " << without;
}

/// Stated samples keep detail; where there is none, nearly all noise goes all the same.
TEST(SampleCounts, OneCountForAllFiltersAWallWithoutDetail) {
  Image3 noisy(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      noisy[1](x, y) = NoisyLight(x, y, kFrames, kMost);
    }
  }
  const double filtered = MeanSquare(Denoised(false, {}));
  EXPECT_LT(filtered, 0.1 * MeanSquare(noisy)) << filtered;
}

TEST(SampleCounts, FractionsAreTheCountsThatTheyStandFor) {
  for (const bool adaptive : {false, true}) {
    const Image3 fractions = Denoised(adaptive, {});
    const Image3 counts = Denoised(adaptive, {"samples=Counts"});
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(fractions[0](x, y), counts[0](x, y));
      }
    }
  }
}

}  // namespace
}  // namespace stillray::sample_counts_test
