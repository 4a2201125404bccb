// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Light in scenes whose answer is known.
#include "render/integrator.h"

#include <string>
#include <utility>

#include "test_scenes.h"

namespace stillray::render::integrator_test {
namespace {

// A convex body of the material, filling the picture, in an environment of radiance 1.
Scene Furnace(const Material& material) {
  // Facets keep some light inside of a glass body that a sphere would let out at once.
  const int subdivisions = material.transmission > 0 ? 5 : 3;
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 0.5f;
  builder.Add(FacetedSphere(vec3(0, 0, -4), 1.0f, subdivisions), material);
  builder.scene.environment.radiance = vec3(1.0f);
  return builder.scene;
}

struct FurnaceCase {
  std::string name;
  Material material;
};

Material Cloth(float sheen, float roughness) {
  Material cloth = Lambert(vec3(1.0f));
  cloth.sheen_color = vec3(sheen);
  cloth.sheen_roughness = roughness;
  return cloth;
}

Material Leaf(float through) {
  Material leaf = Lambert(vec3(1.0f));
  leaf.diffuse_transmission = through;
  return leaf;
}

std::vector<FurnaceCase> FurnaceCases() {
  Material plastic = Metal(vec3(1.0f), 0.4f);
  plastic.metallic = 0.0f;
  Material half_metal = plastic;
  half_metal.metallic = 0.5f;
  const auto coated = [](Material material, float roughness) {
    material.clearcoat = 1.0f;
    material.clearcoat_roughness = roughness;
    return material;
  };
  return {{"lambert", Lambert(vec3(1.0f))},
          {"metal 0", Metal(vec3(1.0f), 0.0f)},
          {"metal 0.2", Metal(vec3(1.0f), 0.2f)},
          {"metal 0.5", Metal(vec3(1.0f), 0.5f)},
          {"metal 0.8", Metal(vec3(1.0f), 0.8f)},
          {"metal 1", Metal(vec3(1.0f), 1.0f)},
          {"dielectric", plastic},
          {"smooth glass", Glass(1.5f, 0.0f)},
          {"rough glass", Glass(1.5f, 0.5f)},
          {"smoothly coated metal", coated(Metal(vec3(1.0f), 0.5f), 0.0f)},
          {"roughly coated metal", coated(Metal(vec3(1.0f), 0.0f), 0.6f)},
          {"coated lambert", coated(Lambert(vec3(1.0f)), 0.3f)},
          {"leaf", Leaf(0.6f)},
          {"cloth", Cloth(1.0f, 0.4f)},
          {"smooth sheen", Cloth(1.0f, 0.0f)},
          {"coated cloth", coated(Cloth(0.7f, 0.8f), 0.2f)},
          {"coated glass", coated(Glass(1.5f, 0.0f), 0.2f)}};
}

TEST(FurnaceTest, WhiteBodiesVanish) {
  for (const FurnaceCase& c : FurnaceCases()) {
    const Scene scene = Furnace(c.material);
    for (const SamplerKind sampler :
         {SamplerKind::kSobol, SamplerKind::kHalton16, SamplerKind::kZSobol}) {
      RenderSettings settings = SmallSettings(32, 32, 1);
      settings.bounces = 32;
      settings.sampler = sampler;
      settings.jitter = true;
      const vec3 mean = Mean(RenderMean(scene, settings, 64));
      EXPECT_NEAR(mean.x, 1.0f, 0.005f) << c.name << ", sampler " << static_cast<int>(sampler);
      EXPECT_NEAR(mean.z, mean.x, 1e-5f) << c.name;
    }
  }
}

TEST(FurnaceTest, ThinSheetsVanishToo) {
  for (const float roughness : {0.0f, 0.5f}) {
    Material sheet = Glass(1.5f, roughness);
    sheet.solid = false;
    RenderSettings settings = SmallSettings(12, 12, 1);
    settings.bounces = 32;
    EXPECT_NEAR(Mean(RenderMean(Furnace(sheet), settings, 512)).x, 1.0f, 0.005f) << roughness;
  }
}

// Irradiance at the origin, on a surface with normal `n`, from a polygon of radiance 1 wholly above
// it: Lambert's formula, 1/2 sum of angles times the edge planes' normals.
float PolygonIrradiance(const std::vector<vec3>& corners, vec3 n) {
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const vec3 a = glm::normalize(corners[i]);
    const vec3 b = glm::normalize(corners[(i + 1) % corners.size()]);
    sum += std::acos(glm::dot(a, b)) * glm::dot(glm::normalize(glm::cross(a, b)), n);
  }
  return static_cast<float>(std::abs(0.5 * sum));
}

// A floor at y = -1 under a lamp of radiance (2, 1, 0.5) at y = 1; the camera looks down.
SceneBuilder FloorUnderLamp(float camera_x) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(camera_x, 0.0f, 0.0f));
  builder.CameraTransform().rotation = Rotation(vec3(1, 0, 0), -kPi / 2);
  builder.scene.cameras[0].yfov = 1e-3f;
  builder.Add(Quad(vec3(-9, -1, 9), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(-1, 1, -0.5f), vec3(2, 0, 0), vec3(0, 0, 1)),
              Emitter(vec3(2.0f, 1.0f, 0.5f)));
  return builder;
}

TEST(DirectLightTest, PlaneUnderRectangleMatchesFormFactor) {
  for (const float x : {0.0f, 0.8f, 2.0f, 5.0f}) {
    const SceneBuilder builder = FloorUnderLamp(x);
    const vec3 p(x, -1, 0);
    const float expected = PolygonIrradiance({vec3(-1, 1, -0.5f) - p, vec3(1, 1, -0.5f) - p,
                                              vec3(1, 1, 0.5f) - p, vec3(-1, 1, 0.5f) - p},
                                             vec3(0, 1, 0)) *
                           0.5f / kPi;
    const Frame frame = RenderOne(builder.scene, SmallSettings(4, 4, 1024));
    const vec3 direct = Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance);
    EXPECT_NEAR(direct.x / (2 * expected), 1.0f, 0.005f) << x;
    EXPECT_NEAR(direct.y / expected, 1.0f, 0.005f) << x;
    EXPECT_NEAR(direct.z / (0.5f * expected), 1.0f, 0.005f) << x;
    EXPECT_EQ(Mean(frame.Find(SignalKind::kDirectSpecular)->radiance), vec3(0.0f));
    EXPECT_EQ(Mean(frame.emission), vec3(0.0f));
  }
}

TEST(DirectLightTest, LampsShineFromTheirFrontUnlessDoubleSided) {
  for (const bool double_sided : {false, true}) {
    SceneBuilder builder = FloorUnderLamp(0.0f);
    std::swap(builder.scene.meshes[1].indices[1], builder.scene.meshes[1].indices[2]);
    std::swap(builder.scene.meshes[1].indices[4], builder.scene.meshes[1].indices[5]);
    builder.scene.materials[1].double_sided = double_sided;
    const vec3 light = Mean(SumOfLight(RenderOne(builder.scene, SmallSettings(2, 2, 16))));
    EXPECT_EQ(light.x > 0.0f, double_sided);
  }
}

// Inside a closed Lambertian box that shines itself, radiance is the same everywhere.
TEST(ClosedBoxTest, RadianceIsTheGeometricSeries) {
  for (const int bounces : {1, 2, 4, 12}) {
    SceneBuilder builder;
    Material material = Lambert(vec3(0.7f, 0.5f, 0.0f));
    material.emission = vec3(1.0f, 2.0f, 3.0f);
    builder.Add(Box(vec3(-1, -2, -3), vec3(2, 1, 1), true), material);
    RenderSettings settings = SmallSettings(20, 20, 256);
    settings.bounces = bounces;
    const Frame frame = RenderOne(builder.scene, settings);
    vec3 expected(0.0f);
    vec3 term = material.emission;
    for (int i = 0; i <= bounces + 1; ++i) {
      expected += term;
      term *= vec3(material.base_color);
    }
    const vec3 sum = Mean(SumOfLight(frame));
    EXPECT_NEAR(sum.x / expected.x, 1.0f, 0.006f) << bounces;
    EXPECT_NEAR(sum.y / expected.y, 1.0f, 0.006f) << bounces;
    EXPECT_NEAR(sum.z / expected.z, 1.0f, 1e-4f) << bounces;
    // Direct light is one reflection of the emission, exactly.
    const vec3 direct = Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance);
    EXPECT_NEAR(direct.x, 0.7f, 0.007f);
    EXPECT_NEAR(Mean(frame.emission).y, 2.0f, 1e-5f);
  }
}

TEST(LightSamplingTest, AllModesHaveTheSameMean) {
  Scene scene = StrategiesScene(0.6f);
  const int mirror = static_cast<int>(scene.materials.size());
  scene.materials.push_back(Metal(vec3(0.9f), 0.0f));
  const int wall = static_cast<int>(scene.meshes.size());
  scene.meshes.push_back(Quad(vec3(-4, 0, 1), vec3(0, 0, -5), vec3(0, 2, 0)));
  scene.meshes.back().material = mirror;
  scene.nodes.push_back({});
  scene.instances.push_back({wall, static_cast<int>(scene.nodes.size()) - 1});
  const RenderSettings settings = SmallSettings(16, 12, 1);
  const float both = Luminance709(Mean(RenderMean(scene, settings, 256)));
  ASSERT_GT(both, 0.3f);
  // The standard deviations of these means are 0.1 to 0.3 %.
  for (const auto& [sampling, spp] : {std::pair{LightSampling::kLight, 256},
                                      {LightSampling::kBsdf, 1024},
                                      {LightSampling::kNone, 1024}}) {
    const float mean = Luminance709(Mean(RenderMean(scene, settings, spp, sampling)));
    EXPECT_NEAR(mean / both, 1.0f, 0.01f) << static_cast<int>(sampling);
  }
}

TEST(LightSamplingTest, LightsWithoutExtentNeedShadowRays) {
  const Scene scene = WallWithLamp();
  RenderSettings settings = SmallSettings(8, 6, 1);
  const Image3 both = RenderMean(scene, settings, 4);
  EXPECT_GT(Mean(both).x, 0.05f);
  for (const LightSampling sampling : {LightSampling::kBsdf, LightSampling::kLight}) {
    const Image3 other = RenderMean(scene, settings, 4, sampling);
    for (int y = 0; y < 6; ++y) {
      for (int x = 0; x < 8; ++x) {
        ASSERT_EQ(Pixel(other, x, y), Pixel(both, x, y));
      }
    }
  }
  settings.light_sampling = LightSampling::kNone;
  const auto renderer = CreateRenderer(scene, settings);
  Frame frame;
  ASSERT_TRUE((*renderer)->RenderFrame({}, &frame).ok());
  EXPECT_EQ(Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance), vec3(0.0f));
  EXPECT_EQ((*renderer)->timings().shadow_rays, 0u);
}

// Weights of a direction that the BSDF samples with density 2 and light sampling with density 6.
TEST(LightSamplingTest, Weights) {
  const float by_bsdf = MisWeight(2.0f, 6.0f);
  EXPECT_NEAR(by_bsdf, 4.0f / 40.0f, 1e-6f);
  EXPECT_EQ(ScatterWeight(2.0f, 6.0f, kSampleMis), by_bsdf);
  EXPECT_EQ(SoughtWeight(6.0f, 2.0f, 0, kSampleMis), MisWeight(6.0f, 2.0f));
  for (const int sampling : {kSampleNone, kSampleBsdf}) {
    EXPECT_EQ(ScatterWeight(2.0f, 6.0f, sampling), 1.0f);
  }
  EXPECT_EQ(SoughtWeight(6.0f, 2.0f, 0, kSampleBsdf), 0.0f);
  EXPECT_EQ(SoughtWeight(6.0f, 2.0f, 1, kSampleBsdf), 1.0f);
  EXPECT_EQ(SoughtWeight(6.0f, 2.0f, 1, kSampleMis), 1.0f);
  EXPECT_EQ(ScatterWeight(2.0f, 6.0f, kSampleLight), 0.0f);
  EXPECT_EQ(SoughtWeight(6.0f, 2.0f, 0, kSampleLight), 1.0f);
  // What light sampling cannot find counts when it is hit.
  for (const int sampling : {kSampleNone, kSampleBsdf, kSampleLight, kSampleMis}) {
    EXPECT_EQ(ScatterWeight(0.0f, 6.0f, sampling), 1.0f);
    EXPECT_EQ(ScatterWeight(2.0f, 0.0f, sampling), 1.0f);
  }
}

TEST(LightSamplingTest, BothIsQuieterThanEither) {
  const Scene scene = StrategiesScene(0.3f);
  const RenderSettings settings = SmallSettings(16, 12, 1);
  const Image3 truth = RenderMean(scene, settings, 1024);
  const auto error = [&](LightSampling sampling) {
    return SquaredError(RenderMean(scene, settings, 16, sampling), truth);
  };
  const double both = error(LightSampling::kMis);
  EXPECT_LT(both, error(LightSampling::kLight));
  EXPECT_LT(both, error(LightSampling::kBsdf));
}

TEST(ClampTest, LimitsTheLargestComponentOfBothLobes) {
  const FoundLight found{vec3(3, 1, 0.5f), vec3(1, 1, 0.5f)};
  const FoundLight clamped = ClampLight(found, 2.0f);  // the sum is (4, 2, 1)
  EXPECT_EQ(clamped.diffuse, vec3(1.5f, 0.5f, 0.25f));
  EXPECT_EQ(clamped.specular, vec3(0.5f, 0.5f, 0.25f));
  EXPECT_EQ(ClampLight(found, 4.0f).diffuse, found.diffuse);
  EXPECT_EQ(ClampLight(found, 0.0f).diffuse, found.diffuse);
}

// A matte wall in the light of the sun reflects albedo times irradiance over pi.
TEST(ClampTest, LimitsReflectedLightAndKeepsWhatTheCameraSees) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-9, -9, -2), vec3(18, 0, 0), vec3(0, 18, 0)),
              Lambert(vec3(0.8f, 0.4f, 0.2f)));
  PunctualLight sun;
  sun.type = LightType::kDirectional;  // along -z of its node, onto the wall
  sun.intensity = vec3(5 * kPi);
  sun.node = builder.AddNode({});
  builder.scene.lights.push_back(sun);
  RenderSettings settings = SmallSettings(4, 4, 1);
  ExpectNear(Mean(RenderMean(builder.scene, settings, 1)), vec3(4, 2, 1), 1e-3f, "off");
  settings.clamp_radiance = 1.0f;
  ExpectNear(Mean(RenderMean(builder.scene, settings, 1)), vec3(1, 0.5f, 0.25f), 1e-5f, "on");
  // Emission and background that the camera sees are kept, and limited in a mirror.
  builder.scene.lights.clear();
  builder.scene.materials[0] = Emitter(vec3(7.0f));
  ExpectNear(Mean(RenderMean(builder.scene, settings, 1)), vec3(7.0f), 1e-5f, "emission");
  builder.scene.materials[0] = Metal(vec3(1.0f), 0.0f);
  builder.scene.environment.radiance = vec3(3.0f, 6.0f, 0.0f);
  ExpectNear(Mean(RenderMean(builder.scene, settings, 1)), vec3(0.5f, 1.0f, 0.0f), 1e-5f, "mirror");
  builder.scene.instances.clear();
  ExpectNear(Mean(RenderMean(builder.scene, settings, 1)), vec3(3, 6, 0), 1e-5f, "background");
}

TEST(SignalsTest, IndirectLightOfADarkCornerIsTheWallsAlone) {
  // A mirror shows a lit wall: the wall's light is indirect and specular, the lamp's own direct.
  SceneBuilder builder;
  builder.Add(Quad(vec3(-1, -1, -2), vec3(2, 0, 0), vec3(0, 2, 0)), Metal(vec3(1.0f), 0.0f));
  builder.Add(Quad(vec3(9, -9, 4), vec3(-18, 0, 0), vec3(0, 18, 0)), Emitter(vec3(1.5f)));
  const Frame frame = RenderOne(builder.scene, SmallSettings(4, 4, 1));
  EXPECT_NEAR(Mean(frame.Find(SignalKind::kDirectSpecular)->radiance).x, 1.5f, 1e-4f);
  EXPECT_EQ(Mean(frame.Find(SignalKind::kIndirectSpecular)->radiance).x, 0.0f);
  EXPECT_EQ(Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance).x, 0.0f);

  builder.scene.materials[1] = Lambert(vec3(0.5f));
  PunctualLight lamp;
  lamp.type = LightType::kDirectional;  // along -z of its node, turned to shine along +z
  Transform turned;
  turned.rotation = Rotation(vec3(0, 1, 0), kPi);
  lamp.node = builder.AddNode(turned);
  lamp.intensity = vec3(2.0f);
  builder.scene.lights.push_back(lamp);
  builder.scene.instances[0].mesh = 0;
  // The mirror's shadow falls straight behind it, beyond the reflections at its edges: look at one.
  builder.scene.nodes[0].local = At(vec3(2.5f, 0, 0));
  builder.scene.nodes[0].local.rotation = Rotation(vec3(0, 1, 0), 0.9f);
  builder.scene.cameras[0].yfov = 0.05f;
  const Frame lit = RenderOne(builder.scene, SmallSettings(4, 4, 1));
  EXPECT_NEAR(Mean(lit.Find(SignalKind::kIndirectSpecular)->radiance).x, 2.0f * 0.5f / kPi, 1e-4f);
  EXPECT_EQ(Mean(lit.Find(SignalKind::kDirectSpecular)->radiance).x, 0.0f);
}

TEST(RegulariseTest, LeavesTheFirstSurfaceAndDimsCaustics) {
  // Directly visible surfaces are unchanged; the mirror behind a diffuse floor becomes rough.
  SceneBuilder builder = FloorUnderLamp(0.0f);
  RenderSettings settings = SmallSettings(4, 4, 64);
  const vec3 plain = Mean(SumOfLight(RenderOne(builder.scene, settings)));
  settings.regularise = true;
  EXPECT_EQ(plain, Mean(SumOfLight(RenderOne(builder.scene, settings))));

  // Light from a narrow beam that only a mirror can bring to the floor: found once it is rough.
  SceneBuilder caustic;
  caustic.CameraTransform() = At(vec3(0, 0, 2));
  caustic.Add(Quad(vec3(-2, -2, -2), vec3(4, 0, 0), vec3(0, 4, 0)), Lambert(vec3(0.8f)));
  caustic.Add(Quad(vec3(2, -2, 3), vec3(-4, 0, 0), vec3(0, 4, 0)), Metal(vec3(1.0f), 0.0f));
  PunctualLight lamp;
  lamp.node = caustic.AddNode(At(vec3(0, 0, 1)));
  lamp.intensity = vec3(1.0f);
  caustic.scene.lights.push_back(lamp);
  settings.regularise = false;
  const vec3 without =
      Mean(RenderOne(caustic.scene, settings).Find(SignalKind::kIndirectDiffuse)->radiance);
  settings.regularise = true;
  const vec3 with =
      Mean(RenderOne(caustic.scene, settings).Find(SignalKind::kIndirectDiffuse)->radiance);
  EXPECT_GT(with.x, 1.2f * without.x);
}

}  // namespace
}  // namespace stillray::render::integrator_test
