// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/aov.h"

namespace stillray {
namespace {

using ::testing::HasSubstr;

constexpr float kInf = std::numeric_limits<float>::infinity();

/// A picture of one pixel.
ExrImage OnePixel(const std::map<std::string, std::vector<float>>& layers) {
  ExrImage image;
  image.width = 1;
  image.height = 1;
  for (const auto& [name, values] : layers) {
    // "DiffDir:RGB" is a layer and its letters.
    const size_t colon = name.find(':');
    const std::string layer = name.substr(0, colon);
    for (size_t c = 0; c < values.size(); ++c) {
      Image1 plane(1, 1);
      plane.Fill(values[c]);
      const std::string letter(1, name[colon + 1 + c]);
      image.Add(layer.empty() ? letter : layer + "." + letter, PixelType::kFloat, plane);
    }
  }
  return image;
}

Result<Frame> Import(const ExrImage& image, const AovOptions& options = {}) {
  const Result<AovLayout> layout = UnderstandAovs(image, options, "file");
  if (!layout.ok()) {
    return layout.status();
  }
  return ImportFrame(image, *layout, {0, 0}, "file");
}

std::array<float, 3> Pixel(const Image3& image) {
  return {image[0](0, 0), image[1](0, 0), image[2](0, 0)};
}
using Rgb = std::array<float, 3>;

std::map<std::string, std::vector<float>> BlenderLayers() {
  return {{"DiffDir:RGB", {1, 2, 3}},
          {"DiffInd:RGB", {0.5f, 0.5f, 0.5f}},
          {"DiffCol:RGB", {0.5f, 0.25f, 1}},
          {"GlossDir:RGB", {1, 0, 0}},
          {"GlossInd:RGB", {0, 1, 0}},
          {"GlossCol:RGB", {1, 1, 0.5f}},
          {"TransDir:RGB", {0, 0, 4}},
          {"TransInd:RGB", {2, 0, 0}},
          {"TransCol:RGB", {0.5f, 0, 0.5f}},
          {"Emit:RGB", {0, 0, 0.125f}},
          {"Env:RGB", {0.25f, 0, 0}},
          {"Depth:Z", {4}},
          {"Normal:XYZ", {0, 0, 0.5f}},
          {"Vector:XYZW", {3, 2, 7, 7}},
          {"IndexOB:X", {5}}};
}

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
  // Another motion than the table's knows nothing of the table's next frame.
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
  const Result<Frame> frame = Import(image);
  ASSERT_TRUE(frame.ok()) << frame.status().message();
  EXPECT_EQ(frame->jitter_x, 0.25f);
  EXPECT_EQ(frame->jitter_y, -0.5f);
  EXPECT_EQ(frame->guides.id(0, 0), 4'000'000'001u);
  EXPECT_EQ(frame->guides.motion[1](0, 0), 2);
  EXPECT_EQ(frame->guides.depth(0, 0), kInf);
  EXPECT_EQ(Pixel(frame->Find(SignalKind::kDirectDiffuse)->radiance), (Rgb{1, 1, 1}));
  EXPECT_EQ(Pixel(SumOfLight(*frame)), (Rgb{3, 3, 3}));
}

}  // namespace
}  // namespace stillray
