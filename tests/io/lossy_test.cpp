// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Detection and removal of artefacts of lossy compression in light.
#include "io/lossy.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/random.h"
#include "stillray/aov.h"

namespace stillray::lossy_test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

/// One sample per pixel: a few are lit, the others black.
Image3 SparseLight(float lit) {
  Image3 light(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float u = UniformFloat(HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)));
      for (int c = 0; c < 3; ++c) {
        light[c](x, y) = u < 0.1f ? lit * (1 + static_cast<float>(c)) * (1 + u) : 0.0f;
      }
    }
  }
  return light;
}

double MeanOf(const Image3& image) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        sum += image[c](x, y);
      }
    }
  }
  return sum / (3.0 * image.width() * image.height());
}

int CountNegative(const Image3& image) {
  int count = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height(); ++y) {
      count += static_cast<int>(std::count_if(image[c].Row(y), image[c].Row(y) + image.width(),
                                              [](float v) { return v < 0; }));
    }
  }
  return count;
}

/// The light of a Blender file with this layer of diffuse light, compressed with DWAA.
ExrImage ThroughDwaa(const Image3& light) {
  ExrImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.compression = ExrCompression::kDwaa;
  Image3 grey(kWidth, kHeight);
  for (int c = 0; c < 3; ++c) {
    grey[c].Fill(0.5f);
  }
  image.Add("ViewLayer.DiffDir.", PixelType::kHalf, light);
  image.Add("ViewLayer.DiffCol.", PixelType::kHalf, grey);
  const Result<std::string> bytes = EncodeExr(image);
  EXPECT_TRUE(bytes.ok()) << bytes.status().message();
  Result<ExrImage> read =
      DecodeExr(reinterpret_cast<const uint8_t*>(bytes->data()), bytes->size(), "dwaa");
  EXPECT_TRUE(read.ok()) << read.status().message();
  return std::move(read.value());
}

Image3 ImportedLight(const ExrImage& image) {
  const Result<AovLayout> layout = UnderstandAovs(image, {}, "file");
  EXPECT_TRUE(layout.ok()) << layout.status().message();
  const Result<Frame> frame = ImportFrame(image, *layout, {0, 0}, "file");
  EXPECT_TRUE(frame.ok()) << frame.status().message();
  return frame->Find(SignalKind::kDirectDiffuse)->radiance;
}

TEST(Lossy, DwaaLeavesNoNegativeLight) {
  for (const float lit : {0.02f, 1.0f, 50.0f}) {
    const Image3 light = SparseLight(lit);
    const ExrImage image = ThroughDwaa(light);
    const Image3 stored = ExrLayer(image, "ViewLayer.DiffDir.").value();
    EXPECT_GT(CountNegative(stored), 100);
    const Image3 imported = ImportedLight(image);
    EXPECT_EQ(CountNegative(imported), 0);
    EXPECT_NEAR(2 * MeanOf(imported) / MeanOf(light), 1, 0.02) << lit;
  }
}

TEST(Lossy, NegativeLightStaysWhereNothingIsBright) {
  ExrImage image = ThroughDwaa(SparseLight(1));
  for (Channel& channel : image.channels) {
    if (channel.name.starts_with("ViewLayer.DiffDir.")) {
      channel.values(30, 20) = -0.5f;
    }
  }
  EXPECT_NEAR(ImportedLight(image)[1](30, 20), -0.25f, 0.01f);  // times a lossy colour
}

TEST(Lossy, AFireflyHidesNoNegativeLightElsewhere) {
  Image3 light(kWidth, kHeight);
  light[0](8, 8) = 1e6f;
  light[1](9, 8) = light[1](17, 17) = light[2](40, 8) = -3;
  light[2](20, 30) = std::nanf("");
  io::RemoveRinging(&light);
  EXPECT_EQ(light[0](8, 8), 1e6f);
  EXPECT_EQ(light[1](9, 8), 0);
  EXPECT_EQ(light[1](17, 17), 0);
  EXPECT_EQ(light[2](40, 8), -3);
  EXPECT_TRUE(std::isnan(light[2](20, 30)));
}

TEST(Lossy, KnowsWhatCodecsTouch) {
  struct Row {
    const char* codec;
    const char* channel;
    PixelType type;
    bool lossy;
  };
  const Row rows[] = {
      {"dwaa", "ViewLayer.DiffDir.R", PixelType::kHalf, true},
      {"dwab", "ViewLayer.Vector.Y", PixelType::kFloat, true},
      {"dwaa", "B", PixelType::kFloat, true},
      {"dwaa", "ViewLayer.Vector.X", PixelType::kFloat, false},
      {"dwaa", "ViewLayer.Depth.Z", PixelType::kFloat, false},
      {"dwaa", "ViewLayer.Combined.A", PixelType::kHalf, false},
      {"dwaa", "id.Y", PixelType::kUint32, false},
      {"b44", "ViewLayer.DiffDir.R", PixelType::kHalf, true},
      {"b44a", "ViewLayer.Normal.X", PixelType::kHalf, true},
      {"b44", "ViewLayer.DiffDir.R", PixelType::kFloat, false},
      {"pxr24", "R", PixelType::kFloat, false},
      {"zip", "R", PixelType::kHalf, false},
      {"piz", "R", PixelType::kHalf, false},
  };
  for (const Row& row : rows) {
    ExrImage image;
    image.compression_name = row.codec;
    Channel channel;
    channel.name = row.channel;
    channel.type = row.type;
    EXPECT_EQ(io::IsLossy(image, channel), row.lossy) << row.codec << " " << row.channel;
  }
}

}  // namespace
}  // namespace stillray::lossy_test
