// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Light that passes through things.
#include <cmath>

#include "render/bsdf_shared.h"
#include "test_scenes.h"

namespace stillray::render::transmission_test {
namespace {

// A floor seen from (0, 0.5, 0) straight down, under a directional light and a big sheet at y = 1.
SceneBuilder FloorUnderSheet(const Material& sheet) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 0.5f, 0));
  builder.CameraTransform().rotation = Rotation(vec3(1, 0, 0), -kPi / 2);
  builder.scene.cameras[0].yfov = 1e-2f;
  builder.Add(Quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(-9, 1, 9), vec3(18, 0, 0), vec3(0, 0, -18)), sheet);
  PunctualLight light;
  light.type = LightType::kDirectional;
  light.intensity = vec3(2.0f);
  Transform down;
  down.rotation = Rotation(vec3(1, 0, 0), -kPi / 2);
  light.node = builder.AddNode(down);
  builder.scene.lights.push_back(light);
  return builder;
}

float DirectLight(const Scene& scene) {
  const Frame frame = RenderOne(scene, SmallSettings(2, 2, 16));
  return Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance).x / (2.0f * 0.5f / kPi);
}

TEST(ShadowTest, BlendedSurfacesLetTheirShareThrough) {
  Material sheet = Lambert(vec3(0.0f));
  sheet.alpha_mode = AlphaMode::kBlend;
  sheet.base_color.w = 0.4f;
  EXPECT_NEAR(DirectLight(FloorUnderSheet(sheet).scene), 0.6f, 1e-4f);
  SceneBuilder two = FloorUnderSheet(sheet);
  two.Add(Quad(vec3(-9, 2, 9), vec3(18, 0, 0), vec3(0, 0, -18)), sheet);
  EXPECT_NEAR(DirectLight(two.scene), 0.36f, 1e-4f);
  sheet.alpha_mode = AlphaMode::kMask;
  EXPECT_NEAR(DirectLight(FloorUnderSheet(sheet).scene), 1.0f, 1e-4f);
  sheet.alpha_cutoff = 0.3f;
  EXPECT_EQ(DirectLight(FloorUnderSheet(sheet).scene), 0.0f);
  sheet.alpha_mode = AlphaMode::kOpaque;
  EXPECT_EQ(DirectLight(FloorUnderSheet(sheet).scene), 0.0f);
}

TEST(ShadowTest, SmoothSheetsLetTintedLightThroughSolidsNone) {
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  sheet.base_color = vec4(0.5f, 1.0f, 1.0f, 1.0f);
  EXPECT_NEAR(DirectLight(FloorUnderSheet(sheet).scene), 0.5f * (1.0f - 0.08f / 1.04f), 1e-4f);
  sheet.solid = true;
  EXPECT_EQ(DirectLight(FloorUnderSheet(sheet).scene), 0.0f);
}

// Both faces of the coat count once, as the sheet's: 0.04 at normal incidence.
TEST(ShadowTest, ClearCoatOnSheetsKeepsItsShare) {
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  sheet.clearcoat = 0.5f;
  const float under = 1.0f - 0.08f / 1.04f;
  EXPECT_NEAR(DirectLight(FloorUnderSheet(sheet).scene), 0.98f * under, 1e-4f);
  sheet.clearcoat_roughness = 0.5f;  // at normal incidence a rough coat reflects much the same
  EXPECT_NEAR(DirectLight(FloorUnderSheet(sheet).scene), 0.98f * under, 3e-3f);
}

// The light below a sheet is the same whether rays to the light or scattered rays find it.
TEST(ShadowTest, LampBehindSheetsIsFoundByAllStrategies) {
  Material clear = Glass(1.5f, 0.0f);
  clear.solid = false;
  Material coated = clear;
  coated.clearcoat = 1.0f;
  coated.clearcoat_roughness = 0.4f;
  Material blend = Lambert(vec3(0.0f));
  blend.alpha_mode = AlphaMode::kBlend;
  blend.base_color.w = 0.3f;
  for (const Material& sheet : {clear, coated, blend}) {
    SceneBuilder builder = FloorUnderSheet(sheet);
    builder.scene.lights.clear();
    builder.Add(Quad(vec3(-1, 2, -1), vec3(2, 0, 0), vec3(0, 0, 2)), Emitter(vec3(3.0f)));
    const RenderSettings settings = SmallSettings(8, 8, 1);
    const float both = Mean(RenderMean(builder.scene, settings, 256)).x;
    const float light = Mean(RenderMean(builder.scene, settings, 256, LightSampling::kLight)).x;
    const float scatter = Mean(RenderMean(builder.scene, settings, 1024, LightSampling::kBsdf)).x;
    ASSERT_GT(both, 0.01f);
    EXPECT_NEAR(light / both, 1.0f, 0.015f) << sheet.clearcoat << ' ' << sheet.base_color.w;
    EXPECT_NEAR(scatter / both, 1.0f, 0.015f) << sheet.clearcoat << ' ' << sheet.base_color.w;
  }
}

// A slab of glass before a wall whose emission rises linearly with x, seen at an angle: all orders
// of internal reflection, each with its offset, Fresnel factors and absorption.
TEST(SlabTest, RefractsReflectsAndAbsorbs) {
  constexpr float kIor = 1.5f;
  constexpr float kThickness = 0.5f;
  constexpr float kAngle = 0.8f;
  SceneBuilder builder;
  builder.CameraTransform().rotation = Rotation(vec3(0, 1, 0), -kAngle);  // towards +x
  builder.scene.cameras[0].yfov = 1e-3f;
  Material glass = Glass(kIor, 0.0f);
  glass.attenuation_distance = 1.0f;
  glass.attenuation_color = vec3(1.0f, 0.5f, 0.25f);
  builder.Add(Box(vec3(-50, -50, -1 - kThickness), vec3(50, 50, -1)), glass);
  Material wall = Emitter(vec3(1.0f));
  Texture ramp;
  ramp.width = 256;
  ramp.height = 1;
  ramp.wrap_u = ramp.wrap_v = Wrap::kClamp;
  for (int i = 0; i < 256; ++i) {
    // sRGB is decoded, so store the encoded value of a linear ramp, as precisely as 8 bits can.
    const auto value =
        static_cast<uint8_t>(std::lround(255 * SrgbEncode((static_cast<float>(i) + 0.5f) / 256)));
    ramp.texels.insert(ramp.texels.end(), {value, value, value, 255});
  }
  builder.scene.textures.push_back(ramp);
  wall.emissive_texture.texture = 0;
  builder.Add(Quad(vec3(0, -50, -4), vec3(10, 0, 0), vec3(0, 100, 0)), wall);

  const float sin_t = std::sin(kAngle) / kIor;
  const float cos_t = std::sqrt(1 - sin_t * sin_t);
  const float r = FresnelDielectric(std::cos(kAngle), kIor);
  const float path = kThickness / cos_t;
  const vec3 through(1.0f, std::pow(0.5f, path), std::pow(0.25f, path));
  const float shift = kThickness * sin_t / cos_t;
  vec3 expected(0.0f);
  vec3 weight = through * ((1 - r) * (1 - r));
  for (int k = 0; k < 6; ++k) {
    const float x = 3.5f * std::tan(kAngle) + static_cast<float>(2 * k + 1) * shift;
    expected += weight * std::min(x / 10, 1.0f);
    weight *= through * through * (r * r);
  }
  RenderSettings settings = SmallSettings(8, 8, 1024);
  settings.bounces = 1;
  const vec3 seen = Mean(SumOfLight(RenderOne(builder.scene, settings)));
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(seen[c] / expected[c], 1.0f, 0.01f) << c;
  }
}

TEST(SlabTest, ThinSheetsDoNotShift) {
  SceneBuilder builder;
  builder.CameraTransform().rotation = Rotation(vec3(0, 1, 0), -0.8f);
  builder.scene.cameras[0].yfov = 1e-3f;
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  sheet.base_color = vec4(0.8f, 1.0f, 1.0f, 1.0f);
  builder.Add(Quad(vec3(-50, -50, -1), vec3(100, 0, 0), vec3(0, 100, 0)), sheet);
  builder.scene.environment.radiance = vec3(1.0f);
  // Everything is white but the tint: reflection + tint * transmission.
  const vec3 seen = Mean(SumOfLight(RenderOne(builder.scene, SmallSettings(8, 8, 1024))));
  const float r = FresnelThinSheet(std::cos(0.8f), 1.5f);
  EXPECT_NEAR(seen.x, r + 0.8f * (1 - r), 0.003f);
  EXPECT_NEAR(seen.y, 1.0f, 1e-4f);
}

TEST(BounceLimitTest, GlassDoesNotCount) {
  // Eight panes (16 boundaries) before a lamp, at one bounce.
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 0.05f;
  for (int i = 0; i < 8; ++i) {
    const float z = -1.0f - 0.5f * static_cast<float>(i);
    Material pane = Glass(1.0001f, 0.0f);
    builder.Add(Box(vec3(-9, -9, z - 0.2f), vec3(9, 9, z)), pane);
  }
  builder.Add(Quad(vec3(-9, -9, -9), vec3(18, 0, 0), vec3(0, 18, 0)), Emitter(vec3(1.0f)));
  RenderSettings settings = SmallSettings(4, 4, 1);
  settings.bounces = 1;
  EXPECT_NEAR(Mean(SumOfLight(RenderOne(builder.scene, settings))).x, 1.0f, 1e-3f);
}

TEST(BounceLimitTest, MirrorsDo) {
  // Two parallel mirrors before a lamp that is seen after one reflection more than allowed.
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(1.0f);
  builder.scene.cameras[0].yfov = 0.01f;
  builder.CameraTransform().rotation = Rotation(vec3(0, 1, 0), -0.3f);
  builder.Add(Quad(vec3(-1, -9, -1), vec3(4, 0, 0), vec3(0, 18, 0)), Metal(vec3(1.0f), 0.0f));
  builder.Add(Quad(vec3(4, -9, 0.5f), vec3(-4, 0, 0), vec3(0, 18, 0)), Metal(vec3(1.0f), 0.0f));
  // From x = 0 the ray advances 1.5 tan(0.3) = 0.46 per reflection after the first 0.31: it meets
  // the front mirror at 0.31, 1.24, 2.17 and the back one at 0.77, 1.70, 2.63, then leaves at 3.1:
  // five reflections after the first.
  for (const int bounces : {1, 3, 4, 5, 8}) {
    RenderSettings settings = SmallSettings(2, 2, 1);
    settings.bounces = bounces;
    const float seen = Mean(SumOfLight(RenderOne(builder.scene, settings))).x;
    EXPECT_NEAR(seen, bounces >= 5 ? 1.0f : 0.0f, 1e-4f) << bounces;
  }
}

}  // namespace
}  // namespace stillray::render::transmission_test
