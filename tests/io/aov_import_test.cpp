// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/aov_importer.h"
#include "io/one_pixel.h"
#include "io/test_files.h"
#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray::aov_import_test {
namespace {

using test::BlenderLayers;
using test::Import;
using test::OnePixel;
using test::Pixel;
using test::Rgb;
using ::testing::HasSubstr;

constexpr float kInf = std::numeric_limits<float>::infinity();

TEST(AovImport, BlenderLightIsMultipliedByItsColour) {
  const Result<Frame> frame = Import(OnePixel(BlenderLayers()));
  ASSERT_TRUE(frame.ok()) << frame.status().message();
  const auto light = [&](SignalKind kind) { return Pixel(frame->Find(kind)->radiance); };
  EXPECT_EQ(light(SignalKind::kDirectDiffuse), (Rgb{0.5f, 0.5f, 3}));
  EXPECT_EQ(light(SignalKind::kIndirectDiffuse), (Rgb{0.25f, 0.125f, 0.5f}));
  EXPECT_EQ(light(SignalKind::kDirectSpecular), (Rgb{1, 0, 0}));
  EXPECT_EQ(light(SignalKind::kIndirectSpecular), (Rgb{0, 1, 0}));
  EXPECT_EQ(light(SignalKind::kDirectTransmission), (Rgb{0, 0, 2}));
  EXPECT_EQ(light(SignalKind::kIndirectTransmission), (Rgb{1, 0, 0}));
  EXPECT_EQ(Pixel(SumOfLight(*frame)), (Rgb{3, 1.625f, 5.625f}));
  EXPECT_EQ(Pixel(frame->guides.albedo), (Rgb{0.5f, 0.25f, 1}));
  EXPECT_EQ(Pixel(frame->guides.transmission_albedo), (Rgb{0.5f, 0, 0.5f}));
}

TEST(AovImport, BlenderGuides) {
  const Result<Frame> frame = Import(OnePixel(BlenderLayers()));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->guides.depth(0, 0), 4);
  EXPECT_EQ(Pixel(frame->guides.normal), (Rgb{0, 0, 1}));
  EXPECT_EQ(frame->guides.motion[0](0, 0), 3);
  EXPECT_EQ(frame->guides.motion[1](0, 0), -2);
  EXPECT_EQ(frame->guides.id(0, 0), 6u);
}

TEST(AovImport, ConfidenceIsALayerOfOurs) {
  const auto confidence = [](const ExrImage& image, const AovOptions& options) {
    const Result<Frame> frame = Import(image, options);
    EXPECT_TRUE(frame.ok()) << frame.status().message();
    return frame->confidence.empty() ? -1.0f : frame->confidence(0, 0);
  };
  std::map<std::string, std::vector<float>> layers = {{":RGB", {1, 1, 1}},
                                                      {"direct_diffuse:RGB", {1, 1, 1}},
                                                      {"albedo:RGB", {1, 1, 1}},
                                                      {"motion:XY", {0, 0}},
                                                      {"depth:Z", {1}}};
  EXPECT_EQ(confidence(OnePixel(layers), {"stillray", {}}), -1);
  layers["confidence:X"] = {0.25f};
  EXPECT_EQ(confidence(OnePixel(layers), {"stillray", {}}), 0.25f);
  EXPECT_EQ(confidence(OnePixel(layers), {"stillray", {"confidence=none"}}), -1);
  layers["valid:Y"] = {0.75f};
  EXPECT_EQ(confidence(OnePixel(layers), {"stillray", {"confidence=valid"}}), 0.75f);
  // Of any renderer, once it is named.
  layers = BlenderLayers();
  layers["valid:X"] = {0.5f};
  EXPECT_EQ(confidence(OnePixel(layers), {}), -1);
  EXPECT_EQ(confidence(OnePixel(layers), {"auto", {"confidence=valid"}}), 0.5f);
}

TEST(AovImport, PreviousNormalsHaveTheAxesOfNormals) {
  const auto previous = [](const ExrImage& image, const AovOptions& options) {
    const Result<Frame> frame = Import(image, options);
    EXPECT_TRUE(frame.ok()) << frame.status().message();
    const Image3& normal = frame->guides.previous_normal;
    return normal.empty() ? Rgb{-9, -9, -9} : Pixel(normal);
  };
  std::map<std::string, std::vector<float>> layers = {{":RGB", {1, 1, 1}},
                                                      {"direct_diffuse:RGB", {1, 1, 1}},
                                                      {"normal:XYZ", {0, 0, 1}},
                                                      {"motion:XY", {0, 0}},
                                                      {"depth:Z", {1}}};
  EXPECT_EQ(previous(OnePixel(layers), {"stillray", {}}), (Rgb{-9, -9, -9}));
  layers["previous_normal:XYZ"] = {0, 1, 0};
  EXPECT_EQ(previous(OnePixel(layers), {"stillray", {}}), (Rgb{0, 1, 0}));
  EXPECT_EQ(previous(OnePixel(layers), {"stillray", {"previous_normal=none"}}), (Rgb{-9, -9, -9}));
  EXPECT_EQ(previous(OnePixel(layers), {"stillray", {"normal=normal,axes=x-zy"}}), (Rgb{0, 0, 1}));
  // Of any renderer, once it is named; zero stays zero.
  layers = BlenderLayers();
  layers["before:XYZ"] = {0, 0, 0};
  EXPECT_EQ(previous(OnePixel(layers), {"auto", {"previous_normal=before"}}), (Rgb{0, 0, 0}));
}

// Motion that is found after importing needs what the stored normals tell.
TEST(AovImport, WhatMixedPixelsLoseInMotionIsReturned) {
  std::map<std::string, std::vector<float>> layers = BlenderLayers();
  for (const bool moves : {true, false}) {
    layers["Vector:XYZW"] = {moves ? 3.0f : 0.0f, 0, 0, 0};
    const ExrImage image = OnePixel(layers);
    AovLayout layout = UnderstandAovs(image, {}, "file").value();
    layout.samples = 16;
    Image1 loss;
    const Result<Frame> frame =
        io::ImportFrameWith(image, layout, {0, 0}, "file", {.loss_in_motion = &loss});
    ASSERT_TRUE(frame.ok()) << frame.status().message();
    EXPECT_NEAR(loss(0, 0), 0.6f, 1e-5f);
    EXPECT_NEAR(frame->confidence(0, 0), moves ? 0.4f : 1.0f, 1e-5f);
  }
  layers["confidence:X"] = {0.5f};  // of the file's own: it stays
  const ExrImage image = OnePixel(layers);
  AovLayout layout = UnderstandAovs(image, {"auto", {"confidence=confidence"}}, "file").value();
  layout.samples = 16;
  Image1 loss = Image1(1, 1);
  EXPECT_EQ(io::ImportFrameWith(image, layout, {0, 0}, "file", {.loss_in_motion = &loss})
                ->confidence(0, 0),
            0.5f);
  EXPECT_TRUE(loss.empty());
}

TEST(AovImport, ConfidenceComesBackFromAFile) {
  const TempFolder folder;
  Image1 confidence(5, 3);
  Image3 light(5, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) {
      confidence(x, y) = static_cast<float>(x + 5 * y) / 16;  // exact in halves
    }
  }
  for (const PixelType type : {PixelType::kHalf, PixelType::kFloat}) {
    ExrImage image;
    image.width = 5;
    image.height = 3;
    image.Add("direct_diffuse.", type, light);
    image.Add("confidence.X", type, confidence);
    const std::string path = folder.Path("frame.exr");
    ASSERT_TRUE(WriteExr(path, image).ok());
    const Result<ExrImage> read = ReadExr(path);
    ASSERT_TRUE(read.ok()) << read.status().message();
    const Result<Frame> frame = Import(*read, {"stillray", {}});
    ASSERT_TRUE(frame.ok()) << frame.status().message();
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 5; ++x) {
        EXPECT_EQ(frame->confidence(x, y), confidence(x, y)) << x << ", " << y;
      }
    }
  }
}

// Blender's ZW is the place now minus the place in the next frame, y up.
TEST(AovImport, TheWayToTheNextFrame) {
  const auto next = [](const ExrImage& image, const AovOptions& options) -> std::vector<float> {
    const Result<AovLayout> layout = UnderstandAovs(image, options, "file");
    EXPECT_TRUE(layout.ok()) << layout.status().message();
    const Image2 motion = ImportNextMotion(image, *layout, {});
    return motion.empty() ? std::vector<float>()
                          : std::vector<float>{motion[0](0, 0), motion[1](0, 0)};
  };
  std::map<std::string, std::vector<float>> layers = BlenderLayers();
  EXPECT_THAT(next(OnePixel(layers), {}), ::testing::ElementsAre(-7, 7));
  // The table's motion to the next frame does not belong to another motion layer.
  EXPECT_THAT(next(OnePixel(layers), {"auto", {"motion=Vector,y_down"}}), ::testing::IsEmpty());
  EXPECT_THAT(next(OnePixel(layers), {"auto", {"motion=Vector,to_next"}}),
              ::testing::ElementsAre(3, -2));
  EXPECT_THAT(next(OnePixel(layers), {"auto", {"next_motion=Vector,channels=ZW,to_next,y_down"}}),
              ::testing::ElementsAre(7, 7));
  layers["Vector:XYZW"] = {3, 2, 0, 0};
  EXPECT_THAT(next(OnePixel(layers), {}), ::testing::IsEmpty());
}

TEST(AovImport, NothingBehindDepthIsASurface) {
  auto layers = BlenderLayers();
  layers["Depth:Z"] = {1e10f};
  for (const char* light : {"DiffDir:RGB", "DiffInd:RGB", "GlossDir:RGB", "GlossInd:RGB",
                            "TransDir:RGB", "TransInd:RGB"}) {
    layers[light] = {0, 0, 0};
  }
  const Result<Frame> frame = Import(OnePixel(layers));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->guides.depth(0, 0), kInf);
  EXPECT_EQ(frame->guides.id(0, 0), 0u);
}

// Combined is 0 where the film is transparent, and Env still holds the sky.
TEST(AovImport, TransparentFilmHasNoSky) {
  auto layers = BlenderLayers();
  for (auto& [name, values] : layers) {
    if (name.ends_with("RGB")) {
      values = {0, 0, 0};
    }
  }
  layers["Env:RGB"] = {0.5f, 0.5f, 0.5f};
  layers["Combined:RGBA"] = {0, 0, 0, 0};
  const Result<Frame> frame = Import(OnePixel(layers));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(Pixel(SumOfLight(*frame)), (Rgb{0, 0, 0}));
}

TEST(AovImport, LightThatNoPassNamesIsKept) {
  auto layers = BlenderLayers();
  layers["Combined:RGB"] = {3, 1.625f, 7};  // 1.375 more in blue
  const Result<Frame> frame = Import(OnePixel(layers));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(Pixel(SumOfLight(*frame)), (Rgb{3, 1.625f, 7}));
  EXPECT_EQ(Pixel(frame->emission), (Rgb{0, 0, 1.5f}));
}

TEST(AovImport, LightOfAPassThatIsMissingIsFiltered) {
  auto layers = BlenderLayers();
  for (const char* name : {"GlossDir:RGB", "GlossInd:RGB", "GlossCol:RGB"}) {
    layers.erase(name);
  }
  layers["Combined:RGB"] = {3, 1.625f, 5.625f};
  const Result<Frame> frame = Import(OnePixel(layers));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(Pixel(frame->Find(SignalKind::kIndirectSpecular)->radiance), (Rgb{1, 1, 0}));
  EXPECT_EQ(Pixel(frame->guides.specular_albedo), (Rgb{1, 1, 1}));
  EXPECT_EQ(Pixel(frame->emission), (Rgb{0, 0, 0.125f}));
}

TEST(AovImport, RoundingOfHalvesIsNoLight) {
  auto layers = BlenderLayers();
  layers["Combined:RGB"] = {3.002f, 1.626f, 5.62f};
  const Result<Frame> frame = Import(OnePixel(layers));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(Pixel(frame->emission), (Rgb{0, 0, 0.125f}));
}

TEST(AovImport, VolumesJoinTransmittedLight) {
  auto layers = BlenderLayers();
  layers["VolumeDir:RGB"] = {8, 8, 8};
  const Result<Frame> frame = Import(OnePixel(layers));
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(Pixel(frame->Find(SignalKind::kDirectTransmission)->radiance), (Rgb{8, 8, 10}));
  EXPECT_EQ(Pixel(frame->guides.transmission_albedo), (Rgb{0.5f, 1, 0.5f}));
}

/// Two pixels of a wall with smoke before it: the depth of the first is that of a sample that the
/// smoke scattered.
ExrImage SmokeBeforeAWall() {
  ExrImage image;
  image.width = 2;
  image.height = 1;
  const auto add = [&](const char* name, float first, float second) {
    Image1 plane(2, 1);
    plane(0, 0) = first;
    plane(1, 0) = second;
    image.Add(name, PixelType::kFloat, plane);
  };
  for (const char* c : {"R", "G", "B"}) {
    add((std::string("DiffDir.") + c).c_str(), 2, 2);
    add((std::string("DiffCol.") + c).c_str(), 0.125f, 0.25f);
    add((std::string("VolumeDir.") + c).c_str(), 0.75f, 0.5f);
  }
  add("Depth.Z", 1e10f, 4);
  add("Normal.X", 0, 0);
  add("Normal.Y", 0, 0);
  add("Normal.Z", 0.25f, 0.5f);
  add("IndexOB.X", 0, 3);
  return image;
}

TEST(AovImport, LightOfVolumesHasADepth) {
  const Result<Frame> frame = Import(SmokeBeforeAWall());
  ASSERT_TRUE(frame.ok()) << frame.status().message();
  const Guides& g = frame->guides;
  EXPECT_EQ(g.depth(0, 0), 4);
  EXPECT_EQ(g.depth(1, 0), 4);
  EXPECT_EQ(g.id(0, 0), 4u);
  for (int x = 0; x < 2; ++x) {
    EXPECT_EQ(g.normal[2](x, 0), 1);
    EXPECT_EQ(g.albedo[0](x, 0), 0.5f) << "of the wall: a quarter and a half of the samples met it";
    EXPECT_EQ(frame->Find(SignalKind::kDirectDiffuse)->radiance[0](x, 0), x == 0 ? 0.25f : 0.5f);
  }
}

TEST(AovImport, PassesOfVolumesAreDividedByTheColoursOfTheFile) {
  const ExrImage image = SmokeBeforeAWall();
  const Result<AovLayout> layout = UnderstandAovs(image, {}, "file");
  ASSERT_TRUE(layout.ok());
  std::vector<LightPart> parts;
  ASSERT_TRUE(ImportFrame(image, *layout, {0, 0}, "file", &parts).ok());
  const auto diffuse = std::find_if(parts.begin(), parts.end(), [](const LightPart& part) {
    return part.aov == Aov::kDirectDiffuse;
  });
  ASSERT_NE(diffuse, parts.end());
  ASSERT_FALSE(diffuse->stored_albedo.empty());
  EXPECT_EQ(diffuse->stored_albedo[0](0, 0), 0.125f);
  EXPECT_EQ(diffuse->stored_albedo[0](1, 0), 0.25f);
}

TEST(AovImport, ColourAlone) {
  const Result<Frame> frame = Import(OnePixel({{"Combined:RGB", {3, 2, 1}},
                                               {"Denoising Albedo:RGB", {0.5f, 0.5f, 0.25f}},
                                               {"Emit:RGB", {1, 0, 1}},
                                               {"Env:RGB", {0, 0.5f, 0}}}),
                                     {"blender", {}});
  ASSERT_TRUE(frame.ok()) << frame.status().message();
  ASSERT_EQ(frame->signals.size(), 1u);
  EXPECT_EQ(frame->signals[0].kind, SignalKind::kDirectDiffuse);
  EXPECT_EQ(Pixel(frame->signals[0].radiance), (Rgb{2, 1.5f, 0}));
  EXPECT_EQ(Pixel(frame->guides.albedo), (Rgb{0.5f, 0.5f, 0.25f}));
  EXPECT_EQ(Pixel(SumOfLight(*frame)), (Rgb{3, 2, 1}));
  EXPECT_TRUE(frame->guides.motion.empty());
  EXPECT_TRUE(frame->guides.transmission_albedo.empty());
}

// GlossCol of Cycles is 1 on all that shines.
TEST(AovImport, ColourAloneIsDividedByTheColoursOfThePasses) {
  std::map<std::string, std::vector<float>> layers = {{"Combined:RGB", {3, 2, 1}},
                                                      {"DiffCol:RGB", {0.5f, 0.25f, 0}},
                                                      {"GlossCol:RGB", {1, 1, 0.5f}},
                                                      {"TransCol:RGB", {0, 0.125f, 0}},
                                                      {"Denoising Albedo:RGB", {9, 9, 9}}};
  Result<Frame> frame = Import(OnePixel(layers), {"blender", {}});
  ASSERT_TRUE(frame.ok()) << frame.status().message();
  EXPECT_EQ(Pixel(frame->guides.albedo), (Rgb{0.54f, 0.415f, 0.02f}));
  frame = Import(OnePixel(layers), {"blender", {"fallback_albedo=Denoising Albedo"}});
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(Pixel(frame->guides.albedo), (Rgb{9, 9, 9}));
}

/// Floor, wall and ceiling with textures; in the middle a ball of glass, where the denoising layers
/// are those of the reflected or refracted surface.
struct GlassPicture {
  static constexpr int kSize = 48;
  ExrImage image;
  static bool IsGlass(int x, int y) { return (x - 24) * (x - 24) + (y - 24) * (y - 24) < 11 * 11; }
  static float Texture(int x, int y) {
    return 0.2f + 0.1f * static_cast<float>((x * 7 + y * 5) % 6);
  }

  explicit GlassPicture(PixelType type) {
    image.width = image.height = kSize;
    Image3 light(kSize, kSize);
    Image3 albedo(kSize, kSize);
    Image3 normal(kSize, kSize);
    Image3 seen(kSize, kSize);
    uint32_t state = 1;
    const auto random = [&state] {
      state = state * 1664525u + 1013904223u;
      return static_cast<float>(state >> 8) / 16777216.0f;
    };
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        std::array<float, 3> n = {0, y < 16 ? 0.0f : 1.0f, y < 16 ? 1.0f : 0.0f};
        n = y >= 36 ? std::array<float, 3>{1, 0, 0} : n;
        // The camera's axes: turned, and left-handed.
        const std::array<float, 3> m = {0.8f * n[0] + 0.6f * n[1], 0.6f * n[0] - 0.8f * n[1], n[2]};
        const size_t hit = static_cast<size_t>(3 * random());
        for (size_t c = 0; c < 3; ++c) {
          const int i = static_cast<int>(c);
          const bool glass = IsGlass(x, y);
          light[i](x, y) = 1;
          normal[i](x, y) = n[c];
          seen[i](x, y) = glass ? (c == hit ? 1.0f : 0.0f) - m[c] : m[c];
          albedo[i](x, y) = glass ? 50 * random() * random() * random() : Texture(x, y);
        }
      }
    }
    image.Add("V.Combined.", PixelType::kFloat, light);
    image.Add("V.Normal.", type, normal, true);
    image.Add("V.Denoising Albedo.", type, albedo);
    image.Add("V.Denoising Normal.", type, seen, true);
  }
};

TEST(AovImport, RandomAlbedoOfGlassIsNotUsed) {
  for (const PixelType type : {PixelType::kHalf, PixelType::kFloat}) {
    const GlassPicture picture(type);
    const Result<AovLayout> layout = UnderstandAovs(picture.image, {}, "file");
    ASSERT_TRUE(layout.ok());
    EXPECT_THAT(layout->notes, ::testing::Contains(HasSubstr("where that is not noise")));
    const Result<Frame> frame = ImportFrame(picture.image, *layout, {0, 0}, "file");
    ASSERT_TRUE(frame.ok());
    for (int y = 0; y < GlassPicture::kSize; ++y) {
      for (int x = 0; x < GlassPicture::kSize; ++x) {
        ASSERT_EQ(frame->guides.albedo[1](x, y),
                  GlassPicture::IsGlass(x, y) ? 1.0f : GlassPicture::Texture(x, y))
            << x << " " << y;
      }
    }
  }
}

/// Passes with noise of mean 1 and a colour made of them.
ExrImage NoisyPasses(const std::function<float(float sum, int x, int y)>& colour, float alpha = 1) {
  constexpr int kSize = 32;
  ExrImage image;
  image.width = image.height = kSize;
  Image3 one(kSize, kSize);
  Image3 light(kSize, kSize);
  Image3 sum(kSize, kSize);
  Image1 opacity(kSize, kSize);
  opacity.Fill(alpha);
  for (int c = 0; c < 3; ++c) {
    one[c].Fill(1);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        light[c](x, y) = (x * 5 + y * 3 + c) % 4 == 0 ? 4.0f : 0.0f;
        sum[c](x, y) = colour(light[c](x, y), x, y);
      }
    }
  }
  image.Add("V.DiffDir.", PixelType::kFloat, light);
  image.Add("V.DiffCol.", PixelType::kFloat, one);
  image.Add("V.GlossDir.", PixelType::kFloat, Image3(kSize, kSize));
  image.Add("V.GlossCol.", PixelType::kFloat, one);
  image.Add("V.TransDir.", PixelType::kFloat, Image3(kSize, kSize));
  image.Add("V.TransCol.", PixelType::kFloat, one);
  image.Add("V.Combined.", PixelType::kFloat, sum);
  image.Add("V.Combined.A", PixelType::kFloat, opacity);
  return image;
}

TEST(AovImport, AColourThatIsCleanAlreadyIsNotAddedToItsPasses) {
  const ExrImage image = NoisyPasses([](float, int, int) { return 1.0f; });
  const Result<AovLayout> layout = UnderstandAovs(image, {}, "file");
  ASSERT_TRUE(layout.ok());
  EXPECT_TRUE(layout->ignores_colour);
  EXPECT_THAT(layout->notes, ::testing::Contains(HasSubstr("V.Combined lacks 75 % of the light")));
  const Result<Frame> frame = ImportFrame(image, *layout, {0, 0}, "file");
  const Result<Frame> passes = Import(image, {"auto", {"colour=none"}});
  ASSERT_TRUE(frame.ok() && passes.ok());
  const Image3 a = SumOfLight(*frame);
  const Image3 b = SumOfLight(*passes);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      ASSERT_EQ(a[0](x, y), b[0](x, y));
    }
  }
  // A layer that is named is used all the same.
  const Result<AovLayout> named = UnderstandAovs(image, {"auto", {"colour=V.Combined"}}, "file");
  ASSERT_TRUE(named.ok());
  EXPECT_FALSE(named->ignores_colour);
}

TEST(AovImport, AColourThatHasMoreThanItsPassesIsKept) {
  const auto ignored = [](const ExrImage& image) {
    const Result<AovLayout> layout = UnderstandAovs(image, {}, "file");
    EXPECT_TRUE(layout.ok());
    return layout.ok() && layout->ignores_colour;
  };
  EXPECT_FALSE(ignored(NoisyPasses([](float v, int, int) { return v; })));
  EXPECT_FALSE(ignored(NoisyPasses([](float v, int x, int) { return x < 9 ? v + 20 : v; })));
  // Rounding, and a shadow catcher behind a film that is not opaque.
  EXPECT_FALSE(ignored(NoisyPasses([](float v, int, int) { return 0.995f * v; })));
  EXPECT_FALSE(ignored(NoisyPasses([](float v, int, int) { return 0.5f * v; }, 0.5f)));
  // The passes lack half of the light: without the colour the picture would be darker.
  EXPECT_FALSE(ignored(NoisyPasses([](float, int, int) { return 2.0f; })));
}

TEST(AovImport, DamageStaysWhereItIs) {
  auto layers = BlenderLayers();
  layers["DiffDir:RGB"] = {std::nanf(""), 2, 3};
  layers["Combined:RGB"] = {std::nanf(""), 1.625f, 5.625f};
  const Result<Frame> frame = Import(OnePixel(layers));
  ASSERT_TRUE(frame.ok());
  EXPECT_TRUE(std::isnan(frame->Find(SignalKind::kDirectDiffuse)->radiance[0](0, 0)));
  EXPECT_EQ(Pixel(frame->emission), (Rgb{0, 0, 0.125f}));
}

TEST(AovImport, AFrameThatLacksAChannelIsRefused) {
  const ExrImage first = OnePixel(BlenderLayers());
  const Result<AovLayout> layout = UnderstandAovs(first, {}, "first");
  ASSERT_TRUE(layout.ok());
  ExrImage second = first;
  std::erase_if(second.channels, [](const Channel& c) { return c.name == "Normal.Y"; });
  const Result<Frame> frame = ImportFrame(second, *layout, {0, 0}, "second.exr");
  EXPECT_EQ(frame.status().code(), StatusCode::kBadData);
  EXPECT_THAT(frame.status().message(), HasSubstr("second.exr: has no channel Normal.Y"));
}

TEST(AovImport, StillraysOwnFramesKeepTheirJitter) {
  ExrImage image = OnePixel({{":RGB", {3, 3, 3}},
                             {"direct_diffuse:RGB", {1, 1, 1}},
                             {"indirect_specular:RGB", {2, 2, 2}},
                             {"albedo:RGB", {0.5f, 0.5f, 0.5f}},
                             {"depth:Z", {kInf}},
                             {"motion:XY", {3, 2}},
                             {"normal:XYZ", {0, 1, 0}}});
  Plane<uint32_t> id(1, 1);
  id.Fill(4'000'000'001u);
  image.Add("id.X", id);
  image.attributes["jitter"] = "0.25 -0.5";
  image.attributes["focal_pixels"] = "935.5";
  const Result<Frame> frame = Import(image);
  ASSERT_TRUE(frame.ok()) << frame.status().message();
  EXPECT_EQ(frame->jitter_x, 0.25f);
  EXPECT_EQ(frame->jitter_y, -0.5f);
  EXPECT_EQ(frame->focal_pixels, 935.5f);
  EXPECT_EQ(frame->guides.id(0, 0), 4'000'000'001u);
  EXPECT_EQ(frame->guides.motion[1](0, 0), 2);
  EXPECT_EQ(frame->guides.depth(0, 0), kInf);
  EXPECT_EQ(Pixel(frame->Find(SignalKind::kDirectDiffuse)->radiance), (Rgb{1, 1, 1}));
  EXPECT_EQ(Pixel(SumOfLight(*frame)), (Rgb{3, 3, 3}));
}

}  // namespace
}  // namespace stillray::aov_import_test
