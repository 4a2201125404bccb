// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames whose transmitted light is separate: what is seen through smooth glass and alpha-blended
// surfaces has signals, an albedo and virtual guides of its own.
#include <cmath>

#include "render/path_shared.h"
#include "scene/builtin.h"
#include "test_scenes.h"

namespace stillray::render::separate_transmission_test {
namespace {

constexpr int kWidth = 24;
constexpr int kHeight = 16;

vec3 LightOf(const Frame& frame, SignalKind kind, int x, int y) {
  return Pixel(frame.Find(kind)->radiance, x, y);
}

/// Direct and indirect light together.
vec3 Specular(const Frame& frame, int x, int y) {
  return LightOf(frame, SignalKind::kDirectSpecular, x, y) +
         LightOf(frame, SignalKind::kIndirectSpecular, x, y);
}
vec3 Transmitted(const Frame& frame, int x, int y) {
  return LightOf(frame, SignalKind::kDirectTransmission, x, y) +
         LightOf(frame, SignalKind::kIndirectTransmission, x, y);
}

Material Sheet(vec3 colour) {
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  sheet.base_color = vec4(colour, 1.0f);
  return sheet;
}

Material Blended(vec3 colour, float alpha) {
  Material blended = Lambert(colour);
  blended.alpha_mode = AlphaMode::kBlend;
  blended.base_color.w = alpha;
  return blended;
}

Mesh Wall(float z, float half) {
  return Quad(vec3(-half, -half, z), vec3(2 * half, 0, 0), vec3(0, 2 * half, 0));
}

// In a white furnace both lights of a sheet are its albedos, without noise at one sample.
TEST(SeparateTransmissionTest, LightOfASheetHasNoNoise) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(1.0f);
  builder.Add(Wall(-4, 9), Sheet(vec3(0.5f, 0.8f, 1.0f)));
  const Frame frame = RenderOne(builder.scene, SmallSettings(kWidth, kHeight, 1));
  ASSERT_EQ(frame.signals.size(), 6u);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const vec3 reflected = Pixel(frame.guides.specular_albedo, x, y);
      const vec3 transmitted = Pixel(frame.guides.transmission_albedo, x, y);
      ExpectNear(Specular(frame, x, y), reflected, 1e-6f, "reflected");
      ExpectNear(Transmitted(frame, x, y), transmitted, 1e-6f, "transmitted");
      ExpectNear(transmitted / vec3(0.5f, 0.8f, 1.0f) + reflected, vec3(1.0f), 1e-5f, "all");
    }
  }
}

// Between a sheet and the wall that is seen through it, every guide keeps to its own surface.
TEST(SeparateTransmissionTest, APaneHasGuidesOfBoth) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(1.0f);
  builder.Add(Wall(-4, 9), Sheet(vec3(1.0f)));
  const int wall = builder.Add(Wall(-9, 40), Lambert(vec3(0.3f, 0.2f, 0.1f)));
  builder.Move(builder.InstanceNode(wall), vec3(0.5f, 0.0f, 0.0f));
  RenderMoment moment;
  moment.seconds = 1.0;
  const Frame frame = RenderOne(builder.scene, SmallSettings(kWidth, kHeight, 1), moment);
  EXPECT_NEAR(frame.guides.depth(12, 8), 4.0f, 1e-4f);
  EXPECT_EQ(frame.guides.id(12, 8), 1u);
  EXPECT_EQ(frame.guides.motion[0](12, 8), 0.0f);
  EXPECT_NEAR(frame.refraction.depth(12, 8), 9.0f, 1e-3f);
  EXPECT_EQ(frame.refraction.id(12, 8), 2u);
  ExpectNear(Pixel(frame.refraction.albedo, 12, 8), vec3(0.3f, 0.2f, 0.1f), 1e-5f);
  const double focal = kHeight * 0.5 / std::tan(0.4);
  EXPECT_NEAR(frame.refraction.motion[0](12, 8), -0.5 / 9 * focal, 1e-3);
  // The sky before the pane, which it reflects.
  EXPECT_TRUE(std::isinf(frame.reflection.depth(12, 8)));
}

// The first blended surface has the frame's guides, the heaviest of the next ones virtual guides.
TEST(SeparateTransmissionTest, BlendedLayersHaveGuidesOfTheirOwn) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(1.0f);
  builder.Add(Wall(-4, 9), Blended(vec3(0.8f, 0.4f, 0.2f), 0.25f));
  builder.Add(Wall(-6, 9), Blended(vec3(0.1f, 0.2f, 0.3f), 0.2f));
  const int wall = builder.Add(Wall(-8, 40), Lambert(vec3(0.3f, 0.6f, 0.9f)));
  builder.Move(builder.InstanceNode(wall), vec3(0.0f, 0.4f, 0.0f));
  RenderMoment moment;
  moment.seconds = 1.0;
  const Frame frame = RenderOne(builder.scene, SmallSettings(kWidth, kHeight, 1), moment);
  EXPECT_NEAR(frame.guides.depth(12, 8), 4.0f, 1e-4f);
  EXPECT_EQ(frame.guides.id(12, 8), 1u);
  // The boundary of a Lambertian reflects some light too.
  const vec3 own = Pixel(frame.guides.albedo, 12, 8);
  EXPECT_NEAR(own.x, 0.8f * 0.25f, 0.02f);
  EXPECT_NEAR(own.y / own.x, 0.5f, 1e-4f);
  ExpectNear(Pixel(frame.guides.transmission_albedo, 12, 8), vec3(0.75f), 1e-6f);
  EXPECT_EQ(frame.refraction.id(12, 8), 3u);
  EXPECT_NEAR(frame.refraction.depth(12, 8), 8.0f, 1e-3f);
  EXPECT_NEAR(frame.refraction.albedo[2](12, 8), 0.9f, 0.05f);
  const double focal = kHeight * 0.5 / std::tan(0.4);
  EXPECT_NEAR(frame.refraction.motion[1](12, 8), 0.4 / 8 * focal, 1e-3);
  EXPECT_EQ(frame.guides.motion[1](12, 8), 0.0f);
}

// Light of the first of two walls is all that the surface's signals have.
TEST(SeparateTransmissionTest, LightOfLayersIsApart) {
  SceneBuilder builder;
  PunctualLight sun;
  sun.type = LightType::kDirectional;
  sun.intensity = vec3(2.0f);
  sun.node = builder.AddNode({});  // along -z
  builder.scene.lights.push_back(sun);
  builder.Add(Wall(-4, 9), Blended(vec3(0.8f, 0.0f, 0.0f), 0.25f));
  builder.Add(Wall(-8, 40), Lambert(vec3(0.0f, 0.5f, 0.0f)));
  RenderSettings settings = SmallSettings(kWidth, kHeight, 4);
  settings.bounces = 1;
  const Frame frame = RenderOne(builder.scene, settings);
  const vec3 front = LightOf(frame, SignalKind::kDirectDiffuse, 12, 8);
  const vec3 behind = LightOf(frame, SignalKind::kDirectTransmission, 12, 8);
  // Irradiance 2, and 3/4 of it behind the first wall; the walls' shares are 1/4 and 3/4.
  EXPECT_NEAR(front.x, 0.25f * frame.guides.albedo[0](12, 8) / 0.25f * 2.0f / kPi, 1e-5f);
  EXPECT_EQ(front.y, 0.0f);
  EXPECT_NEAR(behind.y, 0.75f * frame.refraction.albedo[1](12, 8) * 0.75f * 2.0f / kPi, 0.02f);
  EXPECT_LT(behind.x, 0.05f * behind.y);  // of the boundary, without colour
}

/// All light of a frame.
Image3 PictureOf(const Scene& scene, RenderSettings settings, bool separate) {
  settings.virtual_guides = separate;
  return SumOfLight(RenderOne(scene, settings));
}

double RmsNoise(const Image3& image, const Image3& converged) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const vec3 d = Pixel(image, x, y) - Pixel(converged, x, y);
      sum += static_cast<double>(dot(d, d));
    }
  }
  return std::sqrt(sum / (image.width() * image.height()));
}

/// Glass balls, smooth and slightly rough, behind a sheet and a blended sheet.
SceneBuilder GlassRoom() {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(0.3f, 0.4f, 0.5f);
  builder.Add(MakeSphere(0.8f, 32, 24, 0), Glass(1.5f, 0.0f), At(vec3(-0.9f, 0, -4)));
  builder.Add(MakeSphere(0.8f, 32, 24, 0), Glass(1.5f, 0.1f), At(vec3(0.9f, 0, -4)));
  Material part = Glass(1.4f, 0.05f);
  part.transmission = 0.5f;
  part.base_color = vec4(0.9f, 0.5f, 0.2f, 1.0f);
  builder.Add(MakeSphere(0.5f, 32, 24, 0), part, At(vec3(0, 1, -4)));
  builder.Add(Wall(-7, 12), Lambert(vec3(0.6f, 0.3f, 0.2f)));
  builder.Add(Quad(vec3(-3, -3, -2), vec3(2.8f, 0, 0), vec3(0, 6, 0)), Sheet(vec3(0.9f)));
  builder.Add(Quad(vec3(0.2f, -3, -2), vec3(2.8f, 0, 0), vec3(0, 6, 0)),
              Blended(vec3(0.7f, 0.7f, 0.2f), 0.4f));
  builder.Add(Quad(vec3(-2, 4, -5), vec3(4, 0, 0), vec3(0, 0, 3)), Emitter(vec3(9, 8, 7)));
  return builder;
}

TEST(SeparateTransmissionTest, TheMeanIsTheSameAndNoiseIsLess) {
  const SceneBuilder room = GlassRoom();
  const Image3 converged = RenderMean(room.scene, SmallSettings(kWidth, kHeight, 1), 4096);
  const auto means = [&](bool separate) {
    return PictureOf(room.scene, SmallSettings(kWidth, kHeight, 1024), separate);
  };
  const vec3 expected = Mean(converged);
  for (const bool separate : {false, true}) {
    ExpectNear(Mean(means(separate)) / expected, vec3(1.0f), 0.01f,
               separate ? "separate" : "together");
  }
  const auto noise = [&](bool separate) {
    return RmsNoise(PictureOf(room.scene, SmallSettings(kWidth, kHeight, 4), separate), converged);
  };
  EXPECT_LT(noise(true), 0.95 * noise(false));
}

// All ways of finding light agree, for the parts of rough glass too.
TEST(SeparateTransmissionTest, EveryLightSamplingHasTheSameMean) {
  const SceneBuilder room = GlassRoom();
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1024);
  vec3 means[2];
  for (const LightSampling sampling : {LightSampling::kBsdf, LightSampling::kMis}) {
    settings.light_sampling = sampling;
    means[sampling == LightSampling::kMis ? 1 : 0] = Mean(PictureOf(room.scene, settings, true));
  }
  ExpectNear(means[0] / means[1], vec3(1.0f), 0.02f);
}

TEST(SeparateTransmissionTest, FramesWithoutVirtualGuidesAreNotSeparated) {
  const SceneBuilder room = GlassRoom();
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  const auto separates = [&] {
    const Frame frame = RenderOne(room.scene, settings);
    EXPECT_EQ(frame.signals.size() == 6, !frame.refraction.empty());
    EXPECT_EQ(frame.guides.transmission_albedo.empty(), frame.refraction.empty());
    return frame.signals.size() == 6;
  };
  EXPECT_TRUE(separates());
  settings.virtual_guides = false;
  EXPECT_FALSE(separates());
  settings.virtual_guides = true;
  settings.aperture = 0.05f;
  EXPECT_FALSE(separates());
  settings.aperture = std::nullopt;
  settings.cycle = 4;
  EXPECT_TRUE(separates());
  settings.guides = GuideCoverage::kSparse;
  EXPECT_FALSE(separates());
  const Result<Scene> opaque = MakeBuiltinScene("cornell");
  EXPECT_EQ(RenderOne(*opaque, SmallSettings(kWidth, kHeight, 1)).signals.size(), 4u);
}

// The same object for all of these settings, as a viewer changes them.
TEST(SeparateTransmissionTest, FramesThatAreReusedKeepNothing) {
  const SceneBuilder room = GlassRoom();
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  auto renderer = CreateRenderer(room.scene, settings);
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  for (const bool separate : {true, false, true}) {
    settings.virtual_guides = separate;
    ASSERT_TRUE((*renderer)->SetSettings(settings).ok());
    ASSERT_TRUE((*renderer)->RenderFrame({}, &frame).ok());
    EXPECT_EQ(frame.signals.size(), separate ? 6u : 4u);
    EXPECT_EQ(frame.refraction.empty(), !separate);
    EXPECT_EQ(frame.guides.transmission_albedo.empty(), !separate);
  }
}

// Second moments are those of light divided by the albedo of its kind.
TEST(SeparateTransmissionTest, MomentsAreOfTransmittedLight) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(1.0f);
  builder.Add(Wall(-4, 9), Sheet(vec3(0.5f)));
  const Frame frame = RenderOne(builder.scene, SmallSettings(4, 4, 8));
  // Every sample is 1 after the division.
  EXPECT_NEAR(frame.Find(SignalKind::kDirectTransmission)->second_moment(2, 2), 1.0f, 1e-5f);
  EXPECT_NEAR(frame.Find(SignalKind::kDirectSpecular)->second_moment(2, 2), 1.0f, 1e-4f);
}

}  // namespace
}  // namespace stillray::render::separate_transmission_test
