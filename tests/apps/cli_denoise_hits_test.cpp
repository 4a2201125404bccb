// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise on frames whose mirrors have hit distances: those of stillray's own path tracer,
// made from the images that it writes.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "program.h"
#include "stillray/aov.h"
#include "stillray/io.h"
#include "stillray/vec.h"

namespace stillray::cli_denoise_hits_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kFirst = 33;
constexpr int kLast = 40;

Image1 PlaneOf(const ExrImage& image, const std::string& name) {
  const Channel* channel = image.Find(name);
  EXPECT_NE(channel, nullptr) << name;
  return channel != nullptr ? channel->values : Image1(image.width, image.height);
}

double FocalOf(const ExrImage& image) {
  const auto at = image.attributes.find("focal_pixels");
  double focal = 0;
  if (at == image.attributes.end() ||
      std::from_chars(at->second.data(), at->second.data() + at->second.size(), focal).ec !=
          std::errc()) {
    ADD_FAILURE() << "no focal_pixels";
  }
  return focal;
}

/// Secant of the angle between a pixel's ray and the viewing axis.
double SecantAt(const ExrImage& image, double focal, int x, int y) {
  return std::hypot(x + 0.5 - 0.5 * image.width, y + 0.5 - 0.5 * image.height, focal) / focal;
}

/// The file with the length of reflected rays in place of reflection_depth and the others.
ExrImage WithHits(const ExrImage& image) {
  const Image1 depth = PlaneOf(image, "depth.Z");
  const Image1 images = PlaneOf(image, "reflection_depth.Z");
  const double focal = FocalOf(image);
  Image1 hits(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double length =
          (static_cast<double>(images(x, y)) - depth(x, y)) * SecantAt(image, focal, x, y);
      hits(x, y) = images(x, y) > 0 ? static_cast<float>(length) : 0.0f;
    }
  }
  ExrImage file = image;
  Image3 albedo(image.width, image.height);
  for (int c = 0; c < 3; ++c) {
    const std::string letter(1, "RGB"[c]);
    const Image1 mirror = PlaneOf(image, "specular_albedo." + letter);
    albedo[c] = PlaneOf(image, "reflection_albedo." + letter);
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        albedo[c](x, y) *= mirror(x, y);  // times the throughput of the path
      }
    }
  }
  file.Add("seen_albedo.", PixelType::kFloat, albedo);
  for (const char letter : {'X', 'Y', 'Z'}) {
    file.Add(std::string("seen_normal.") + letter, PixelType::kFloat,
             PlaneOf(image, std::string("reflection_normal.") + letter));
  }
  std::erase_if(file.channels,
                [](const Channel& channel) { return channel.name.starts_with("reflection_"); });
  file.Add("hits.Z", PixelType::kFloat, hits);
  return file;
}

/// Pixels of smooth, planar mirrors, by the normals around them.
std::vector<ivec2> MirrorPixels(const ExrImage& image) {
  constexpr int kReach = 2;
  constexpr int kSide = 2 * kReach + 1;
  const Image1 normal[] = {PlaneOf(image, "normal.X"), PlaneOf(image, "normal.Y"),
                           PlaneOf(image, "normal.Z")};
  const Image1 shown = PlaneOf(image, "reflection_depth.Z");
  const Image1 rough = PlaneOf(image, "roughness.X");
  const auto is_mirror = [&](int x, int y, int u, int v) {
    float cosine = 0;
    for (const Image1& plane : normal) {
      cosine += plane(x, y) * plane(u, v);
    }
    return cosine > 0.99999f && shown(u, v) > 0 && rough(u, v) <= 0.1f;
  };
  std::vector<ivec2> pixels;
  for (int y = kReach; y < image.height - kReach; ++y) {
    for (int x = kReach; x < image.width - kReach; ++x) {
      bool all = true;
      for (int i = 0; i < kSide * kSide && all; ++i) {
        all = is_mirror(x, y, x - kReach + i % kSide, y - kReach + i / kSide);
      }
      if (all) {
        pixels.emplace_back(x, y);
      }
    }
  }
  return pixels;
}

/// Those of mirrors that stand still: the large one of the scene turns by 0.003 radians a frame.
std::vector<ivec2> Still(const std::vector<ivec2>& pixels, const ExrImage& now,
                         const ExrImage& before) {
  constexpr float kTurned = 0.001f;
  std::vector<ivec2> still;
  for (const ivec2& p : pixels) {
    float turn2 = 0;
    for (const char* name : {"normal.X", "normal.Y", "normal.Z"}) {
      turn2 +=
          std::pow(now.Find(name)->values(p.x, p.y) - before.Find(name)->values(p.x, p.y), 2.0f);
    }
    if (turn2 < kTurned * kTurned) {
      still.push_back(p);
    }
  }
  return still;
}

class HitDistances : public ::testing::Test {
 protected:
  void SetUp() override {
    Program({"render", "builtin:mirrors", "-o", folder_ / "in", "--size", "160x90", "--frames",
             std::to_string(kFirst) + "-" + std::to_string(kLast), "--no-jitter", "--format", "exr",
             "--save-inputs", "--device", "cpu"});
    for (int frame = kFirst; frame <= kLast; ++frame) {
      const Result<ExrImage> image = ReadExr(FrameFileName(folder_ / "in/noisy.####.exr", frame));
      ASSERT_TRUE(image.ok()) << image.status().message();
      ASSERT_TRUE(WriteExr(FrameFileName(folder_ / "hits.####.exr", frame), WithHits(*image)).ok());
      std::swap(last_, before_);
      last_ = *image;
    }
    mirror_ = MirrorPixels(last_);
    ASSERT_GT(mirror_.size(), 300u);
  }

  static std::string Program(const std::vector<std::string>& arguments) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    return run.output;
  }

  Image3 Denoised(const std::string& in, const std::string& name,
                  const std::vector<std::string>& more) {
    const std::string out = folder_ / (name + ".####.exr");
    std::vector<std::string> arguments = {"denoise",  in,         "-o",  out,        "--renderer",
                                          "stillray", "--device", "cpu", "--window", "past"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    output_ = Program(arguments);
    return PictureAt(FrameFileName(out, kLast));
  }

  static Image3 PictureAt(const std::string& path) {
    const Result<Image3> picture = ReadImage(path);
    EXPECT_TRUE(picture.ok()) << picture.status().message();
    return picture.ok() ? *picture : Image3();
  }

  /// Mean squared difference of two pictures in the planar mirrors.
  double Apart(const Image3& a, const Image3& b) const {
    const auto tone = [](float v) { return static_cast<double>(v / (1 + v)); };
    double sum = 0;
    for (const ivec2& p : mirror_) {
      for (int c = 0; c < 3; ++c) {
        sum += std::pow(tone(a[c](p.x, p.y)) - tone(b[c](p.x, p.y)), 2);
      }
    }
    return sum / (3 * static_cast<double>(mirror_.size()));
  }

  const TemporaryFolder folder_;
  ExrImage last_;
  ExrImage before_;  ///< the frame before it
  std::vector<ivec2> mirror_;
  std::string output_;
};

TEST_F(HitDistances, KeepReflectionsSharp) {
  ASSERT_GT(mirror_.size(), 4000u);
  const std::string hits = folder_ / "hits.####.exr";
  Program({"render", "builtin:mirrors", "-o", folder_ / "ref", "--size", "160x90", "--frames",
           std::to_string(kLast) + "-" + std::to_string(kLast), "--no-jitter", "--format", "exr",
           "--reference", "128", "--seed", "1000", "--device", "cpu"});
  const Image3 truth = PictureAt(FrameFileName(folder_ / "ref/reference.####.exr", kLast));
  const double images = Apart(Denoised(folder_ / "in/noisy.####.exr", "images", {}), truth);
  const double without = Apart(Denoised(hits, "without", {}), truth);
  EXPECT_THAT(output_, Not(HasSubstr("reflections follow")));
  const double alone = Apart(Denoised(hits, "alone", {"--aov", "hit_distance=hits"}), truth);
  EXPECT_THAT(output_, HasSubstr("note: reflections follow hits"));
  const double with =
      Apart(Denoised(hits, "with",
                     {"--aov", "hit_distance=hits", "--aov", "seen_normal=seen_normal", "--aov",
                      "seen_albedo=seen_albedo"}),
            truth);
  EXPECT_LT(alone, without);
  EXPECT_LT(with, 0.4 * without) << with << " " << without;  // 0.27 measured
  EXPECT_LT(with, 1.2 * images) << with << " " << images;    // 1.07 measured
}

TEST_F(HitDistances, GiveTheGuidesThatTheTracerWrites) {
  const auto frame_of = [](const ExrImage& image, const std::vector<std::string>& mappings) {
    const Result<AovLayout> layout = UnderstandAovs(image, {"stillray", mappings}, "file");
    EXPECT_TRUE(layout.ok()) << layout.status().message();
    Result<Frame> frame = ImportFrame(image, *layout, {0, 0}, "file");
    EXPECT_TRUE(frame.ok()) << frame.status().message();
    return frame.ok() ? std::move(*frame) : Frame();
  };
  const Frame expected = frame_of(last_, {});
  const Frame found = frame_of(WithHits(last_), {"hit_distance=hits"});
  const VirtualGuides& e = expected.reflection;
  const VirtualGuides& f = found.reflection;
  for (const ivec2& p : mirror_) {
    const float depth = e.depth(p.x, p.y);
    ASSERT_NEAR(f.depth(p.x, p.y), depth, 1e-5f * depth) << p.x << ", " << p.y;
  }
  const std::vector<ivec2> still = Still(mirror_, last_, before_);
  EXPECT_GT(still.size(), 2000u);
  size_t right = 0;
  float apart = 0;
  for (const ivec2& p : still) {
    const auto distance = [&](const Image2& a, const Image2& b) {
      return std::hypot(a[0](p.x, p.y) - b[0](p.x, p.y), a[1](p.x, p.y) - b[1](p.x, p.y));
    };
    right += distance(e.motion, f.motion) < 0.005f ? 1 : 0;
    apart = std::max(apart, distance(e.motion, expected.guides.motion));
  }
  EXPECT_GT(right, 95 * still.size() / 100);
  EXPECT_GT(apart, 0.1f);
}

}  // namespace
}  // namespace stillray::cli_denoise_hits_test
