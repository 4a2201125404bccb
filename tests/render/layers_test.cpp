// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Materials with the extensions of glTF beyond metallic-roughness and transmission.
#include "render/layers_shared.h"

#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "render/sampler_shared.h"
#include "render/sheen_shared.h"
#include "render/surface.h"
#include "test_scenes.h"

namespace stillray::render::layers_test {
namespace {

using ::testing::HasSubstr;

/// A quad that fills the picture of a camera that looks straight at it.
SceneBuilder WallOf(const Material& material) {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 1e-3f;
  builder.Add(Quad(vec3(-9, -9, -3), vec3(18, 0, 0), vec3(0, 18, 0)), material);
  builder.scene.environment.radiance = vec3(1.0f);
  return builder;
}

Texture UniformTexture(uint8_t r, uint8_t g, uint8_t b, uint8_t a) {
  Texture texture;
  texture.width = texture.height = 1;
  texture.texels = {r, g, b, a};
  return texture;
}

vec3 SpecularAlbedoOf(const SceneBuilder& builder) {
  return Mean(RenderOne(builder.scene, SmallSettings(2, 2, 1)).guides.specular_albedo);
}

vec3 DiffuseAlbedoOf(const SceneBuilder& builder) {
  return Mean(RenderOne(builder.scene, SmallSettings(2, 2, 1)).guides.albedo);
}

// ((1.5 - 1) / (1.5 + 1))^2 = 0.04, times the factors; the diffuse light is what the largest
// component leaves.
TEST(SpecularTest, ReflectanceAtNormalIncidenceByHand) {
  Material plastic = Plastic(0.0f);
  plastic.specular = 0.5f;
  plastic.specular_color = vec3(2.0f, 1.0f, 0.25f);
  ExpectNear(SpecularAlbedoOf(WallOf(plastic)), vec3(0.04f, 0.02f, 0.005f), 1e-5f);
  ExpectNear(DiffuseAlbedoOf(WallOf(plastic)), vec3(0.96f), 1e-5f);
  plastic.specular_color = vec3(1000.0f, 1.0f, 0.0f);  // reflectances end at 1
  ExpectNear(SpecularAlbedoOf(WallOf(plastic)), vec3(0.5f, 0.02f, 0.0f), 1e-5f);
  ExpectNear(DiffuseAlbedoOf(WallOf(plastic)), vec3(0.5f), 1e-5f);
  plastic.specular = 0.0f;
  ExpectNear(SpecularAlbedoOf(WallOf(plastic)), vec3(0.0f), 0.0f);
  ExpectNear(DiffuseAlbedoOf(WallOf(plastic)), vec3(1.0f), 0.0f);
}

TEST(SpecularTest, MetalsKeepTheirColour) {
  Material metal = Metal(vec3(0.9f, 0.6f, 0.3f), 0.0f);
  metal.specular = 0.1f;
  metal.specular_color = vec3(0.0f, 1.0f, 9.0f);
  ExpectNear(SpecularAlbedoOf(WallOf(metal)), vec3(0.9f, 0.6f, 0.3f), 1e-5f);
}

TEST(SpecularTest, TexturesAreAlphaAndSrgbColour) {
  Material plastic = Plastic(0.0f);
  SceneBuilder builder = WallOf(plastic);
  builder.scene.textures = {UniformTexture(1, 2, 3, 51), UniformTexture(255, 128, 0, 9)};
  builder.scene.materials[0].specular_texture.texture = 0;
  ExpectNear(SpecularAlbedoOf(builder), vec3(0.04f * 0.2f), 1e-6f);
  builder.scene.materials[0].specular_color_texture.texture = 1;
  ExpectNear(SpecularAlbedoOf(builder), 0.008f * vec3(1.0f, SrgbDecode(128.0f / 255), 0.0f), 1e-6f);
}

Material Coated(Material material, float coat, float roughness) {
  material.clearcoat = coat;
  material.clearcoat_roughness = roughness;
  return material;
}

// Schlick with 0.04: 0.04 at normal incidence, 0.04 + 0.96 / 32 = 0.07 at 60 degrees.
TEST(ClearCoatTest, ReflectanceByHand) {
  const SceneBuilder straight = WallOf(Coated(Lambert(vec3(1.0f)), 0.5f, 0.0f));
  ExpectNear(SpecularAlbedoOf(straight), vec3(0.02f), 1e-5f);
  ExpectNear(DiffuseAlbedoOf(straight), vec3(0.98f), 1e-5f);
  SceneBuilder tilted = WallOf(Coated(Lambert(vec3(0.5f)), 1.0f, 0.0f));
  tilted.CameraTransform().rotation = Rotation(vec3(0, 1, 0), kPi / 3);
  ExpectNear(SpecularAlbedoOf(tilted), vec3(0.07f), 1e-4f);
  ExpectNear(DiffuseAlbedoOf(tilted), vec3(0.5f * 0.93f), 1e-4f);
}

// What is below is scaled by the same factor, whatever it is.
TEST(ClearCoatTest, DarkensWhatItCovers) {
  Material metal = Metal(vec3(0.9f, 0.5f, 0.1f), 0.4f);
  const vec3 bare = SpecularAlbedoOf(WallOf(metal));
  ExpectNear(SpecularAlbedoOf(WallOf(Coated(metal, 1.0f, 0.0f))), 0.96f * bare + vec3(0.04f),
             1e-5f);
}

TEST(ClearCoatTest, TexturesAreRedAndGreen) {
  SceneBuilder builder = WallOf(Coated(Lambert(vec3(0.0f)), 0.5f, 1.0f));
  builder.scene.textures = {UniformTexture(51, 2, 3, 4), UniformTexture(1, 0, 3, 4)};
  builder.scene.materials[0].clearcoat_texture.texture = 0;
  builder.scene.materials[0].clearcoat_roughness_texture.texture = 1;  // smooth
  ExpectNear(SpecularAlbedoOf(builder), vec3(0.04f * 0.5f * 0.2f), 1e-6f);
}

// The roughness guide is that of the reflection which gives most of the light.
TEST(ClearCoatTest, RoughnessGuideIsThatOfTheStrongerReflection) {
  const auto roughness = [](const Material& material) {
    return RenderOne(WallOf(material).scene, SmallSettings(1, 1, 1)).guides.roughness(0, 0);
  };
  EXPECT_NEAR(roughness(Coated(Lambert(vec3(0.5f)), 1.0f, 0.2f)), 0.2f, 1e-6f);
  EXPECT_NEAR(roughness(Coated(Metal(vec3(0.5f), 0.7f), 1.0f, 0.2f)), 0.7f, 1e-6f);
}

/// A coated black wall with a normal map, below a lamp without extent.
Frame LitWall(bool base_map, bool coat_map) {
  SceneBuilder builder = WallOf(Coated(Lambert(vec3(0.0f)), 1.0f, 0.5f));
  builder.scene.environment.radiance = vec3(0.0f);
  builder.scene.textures = {UniformTexture(180, 90, 220, 255)};
  builder.scene.materials[0].normal_texture.texture = base_map ? 0 : -1;
  builder.scene.materials[0].clearcoat_normal_texture.texture = coat_map ? 0 : -1;
  PunctualLight light;
  light.type = LightType::kDirectional;
  light.intensity = vec3(2.0f);
  Transform pose;
  pose.rotation = Rotation(glm::normalize(vec3(1, 2, 0)), 0.4f);
  light.node = builder.AddNode(pose);
  builder.scene.lights.push_back(light);
  return RenderOne(builder.scene, SmallSettings(2, 2, 1));
}

TEST(ClearCoatTest, HasANormalMapOfItsOwn) {
  const auto light = [](bool base_map, bool coat_map) {
    const Frame frame = LitWall(base_map, coat_map);
    return Mean(frame.Find(SignalKind::kDirectSpecular)->radiance).x;
  };
  const float even = light(false, false);
  const float bent = light(false, true);
  ASSERT_GT(even, 0.0f);
  EXPECT_GT(std::abs(bent / even - 1.0f), 0.2f);
  EXPECT_NEAR(light(true, false) / even, 1.0f, 1e-3f) << "the base's map is not the coat's";
  EXPECT_NEAR(light(true, true) / bent, 1.0f, 1e-3f);
}

/// A surface of the material in the plane z = 0, with another normal for the coat.
Surface SurfaceWithCoatNormal(const Material& material, vec3 wo, vec3 normal) {
  Surface surface;
  surface.geometric = vec3(0, 0, 1);
  surface.frame = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
  surface.wo = surface.local_wo = wo;
  surface.front = 1;
  surface.solid = material.solid ? 1 : 0;
  surface.material = &material;
  surface.base_colour = vec3(material.base_color);
  surface.metallic = material.metallic;
  surface.roughness = material.roughness;
  surface.transmission = material.transmission;
  surface.layered = true;
  surface.layers = LayersOf(material);
  surface.layers.coat_normal = normal;
  return surface;
}

const BsdfTables& Tables() {
  static const BsdfTables kTables(Scene(), false);
  return kTables;
}

/// The mean weight of samples, and the integral of the BSDF and of its density over the sphere by a
/// grid.
struct Integrals {
  glm::dvec3 sampled{0.0};
  glm::dvec3 integrated{0.0};
  double density = 0;
  double lost = 0;  // part of the samples without a direction
};

Integrals Integrate(const Bsdf& bsdf, vec3 wo) {
  Integrals sums;
  constexpr uint32_t kCount = 16384;
  for (uint32_t i = 0; i < kCount; ++i) {
    const BsdfSample s = SampleBsdf(bsdf, wo, SobolSample(i, 5), kAllLobes);
    sums.lost += s.kind == kScatterNone ? 1.0 / kCount : 0.0;
    sums.sampled += glm::dvec3(s.diffuse + s.specular) / static_cast<double>(kCount);
  }
  constexpr int kCosines = 400;
  constexpr int kAzimuths = 400;
  for (int i = 0; i < kCosines; ++i) {
    for (int j = 0; j < kAzimuths; ++j) {
      const double z = (i + 0.5) / kCosines * 2 - 1;
      const double phi = (j + 0.5) / kAzimuths * 2 * 3.14159265358979;
      const double r = std::sqrt(1 - z * z);
      const BsdfValue value = EvaluateBsdf(
          bsdf, wo, vec3(glm::dvec3(r * std::cos(phi), r * std::sin(phi), z)), kAllLobes);
      const double area = 4 * 3.14159265358979 / (kCosines * kAzimuths);
      sums.integrated += glm::dvec3(value.diffuse + value.specular) * area;
      sums.density += value.density * area;
    }
  }
  return sums;
}

void ExpectConsistent(const Integrals& sums, const std::string& what) {
  EXPECT_NEAR(sums.density + sums.lost, 1.0, 0.01) << what;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(sums.sampled[k], sums.integrated[k], 0.01) << what << " channel " << k;
    EXPECT_LT(sums.integrated[k], 1.01) << what << " gains light";
  }
}

// With the coat's normal tilted some of its light is lost, none is gained.
TEST(ClearCoatTest, SamplesAgreeWithValuesAroundAnyNormal) {
  for (const Material& base : {Lambert(vec3(1.0f)), Metal(vec3(1.0f, 0.5f, 0.2f), 0.5f)}) {
    for (const float tilt : {0.0f, 0.3f, -0.6f}) {
      const Material coated = Coated(base, 1.0f, 0.4f);
      const vec3 wo(std::sin(0.7f), 0.0f, std::cos(0.7f));
      const vec3 normal(std::sin(tilt), 0.0f, std::cos(tilt));
      const Bsdf bsdf = Tables().Make(SurfaceWithCoatNormal(coated, wo, normal), 0.0f);
      ExpectConsistent(Integrate(bsdf, wo), "tilt " + std::to_string(tilt));
    }
  }
}

// The lobe alone, before its energy compensation.
TEST(ClearCoatTest, LobeIsReciprocal) {
  const Material coated = Coated(Lambert(vec3(0.0f)), 1.0f, 0.6f);
  const vec3 a(std::sin(0.4f), 0.0f, std::cos(0.4f));
  const vec3 b(0.0f, std::sin(1.1f), std::cos(1.1f));
  const vec3 normal = glm::normalize(vec3(0.1f, 0.2f, 1.0f));
  const Bsdf from_a = Tables().Make(SurfaceWithCoatNormal(coated, a, normal), 0.0f);
  const Bsdf from_b = Tables().Make(SurfaceWithCoatNormal(coated, b, normal), 0.0f);
  const float ab =
      EvaluateBsdf(from_a, a, b, kAllLobes).specular.x / (from_a.coat_scale * glm::dot(b, normal));
  const float ba =
      EvaluateBsdf(from_b, b, a, kAllLobes).specular.x / (from_b.coat_scale * glm::dot(a, normal));
  ASSERT_GT(ab, 0.0f);
  EXPECT_NEAR(ab / ba, 1.0f, 1e-4f);
}

vec3 Towards(double cosine, double azimuth) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return vec3(glm::dvec3(sine * std::cos(azimuth), sine * std::sin(azimuth), cosine));
}

Material Cloth(vec3 base, vec3 sheen, float roughness) {
  Material cloth = Lambert(base);
  cloth.sheen_color = sheen;
  cloth.sheen_roughness = roughness;
  return cloth;
}

// The projected area of all microfacets is that of the surface.
TEST(SheenTest, DistributionIsNormalised) {
  for (const float roughness : {0.0f, 0.1f, 0.3f, 0.7f, 1.0f}) {
    const float alpha = SheenAlpha(roughness);
    constexpr int kSteps = 100000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double cosine = (i + 0.5) / kSteps;
      sum += cosine * SheenDensity(static_cast<float>(1 - cosine * cosine), alpha);
    }
    EXPECT_NEAR(sum / kSteps * 2 * 3.14159265358979, 1.0, 1e-4) << roughness;
  }
}

// alpha = 1: D = 3 / (2 pi) sin; Lambda at cosine 1 is exp(2 L(0.5) - L(0)) with L(0) = 21.5473 -
// 4.32054 and L(0.5) = 21.5473 / (1 + 3.82987 * 0.871618) - 0.9888 - 4.32054 = -0.34245.
TEST(SheenTest, ValuesWorkedByHand) {
  EXPECT_NEAR(SheenDensity(0.25f, 1.0f), 3.0 / (2 * 3.14159265) * 0.5, 1e-6);
  EXPECT_NEAR(SheenDensity(1.0f, 0.25f), 6.0 / (2 * 3.14159265), 1e-6);
  EXPECT_NEAR(std::log(SheenLambda(0.5f, 1.0f)), -0.34245, 2e-5);
  EXPECT_NEAR(std::log(SheenLambda(1.0f, 1.0f)), -2 * 0.34245 - 17.22676, 1e-4);
}

TEST(SheenTest, LobeIsReciprocal) {
  const vec3 a = Towards(0.2, 0.3);
  const vec3 b = Towards(0.7, 2.6);
  for (const float alpha : {0.01f, 0.3f, 1.0f}) {
    EXPECT_NEAR(EvaluateSheen(a, b, alpha) * a.z, EvaluateSheen(b, a, alpha) * b.z, 1e-6f);
  }
}

// The guide's albedo against an integral by another grid, of half the azimuth in even angles.
TEST(SheenTest, AlbedoIsTheIntegralOfTheLobe) {
  for (const float roughness : {0.1f, 0.25f, 0.5f, 0.8f, 1.0f}) {
    const Material cloth = Cloth(vec3(0.0f), vec3(1.0f), roughness);
    for (const double cosine : {0.03, 0.15, 0.4, 0.8, 1.0}) {
      const vec3 wo = Towards(cosine, 0);
      constexpr int kAngles = 600;
      double sum = 0;
      for (int i = 0; i < kAngles; ++i) {
        const double theta = (i + 0.5) / kAngles * 3.14159265358979 / 2;
        for (int j = 0; j < kAngles; ++j) {
          const double phi = (j + 0.5) / kAngles * 3.14159265358979;
          sum += EvaluateSheen(wo, Towards(std::cos(theta), phi), SheenAlpha(roughness)) *
                 std::sin(theta);
        }
      }
      sum *= 3.14159265358979 * 3.14159265358979 / (kAngles * kAngles);
      const Bsdf bsdf = Tables().Make(SurfaceWithCoatNormal(cloth, wo, vec3(0, 0, 1)), 0.0f);
      EXPECT_NEAR(DiffuseAlbedo(bsdf).x, std::min(sum, 1.0), 0.01) << roughness << ' ' << cosine;
    }
  }
}

TEST(SheenTest, SamplesAgreeWithValuesAndGainNoLight) {
  for (const float roughness : {0.1f, 0.5f, 1.0f}) {
    for (const double cosine : {0.1, 0.5, 0.95}) {
      const vec3 wo = Towards(cosine, 0.4);
      const Material cloth =
          Coated(Cloth(vec3(1.0f), vec3(1.0f, 0.4f, 0.0f), roughness), 0.5f, 0.6f);
      const Bsdf bsdf = Tables().Make(SurfaceWithCoatNormal(cloth, wo, vec3(0, 0, 1)), 0.0f);
      ExpectConsistent(Integrate(bsdf, wo), fmt::format("{} {}", roughness, cosine));
    }
  }
}

// Sheen dims what is below by its largest component.
TEST(SheenTest, DimsWhatItCovers) {
  SceneBuilder tilted = WallOf(Cloth(vec3(0.5f), vec3(0.8f, 0.4f, 0.0f), 0.5f));
  tilted.CameraTransform().rotation = Rotation(vec3(0, 1, 0), 1.2f);
  const vec3 seen = DiffuseAlbedoOf(tilted);
  const float share = (seen.x - seen.z) / 0.8f;  // what the lobe reflects, if white
  EXPECT_GT(share, 0.1f);
  EXPECT_NEAR((seen.y - seen.z) / 0.4f, share, 1e-5f);
  EXPECT_NEAR(seen.z, 0.5f * (1.0f - 0.8f * share), 1e-5f);
}

TEST(SheenTest, TexturesAreSrgbColourAndAlpha) {
  SceneBuilder expected = WallOf(Cloth(vec3(0.0f), vec3(0.5f, 0.25f, 0.0f), 0.4f));
  expected.scene.materials[0].sheen_color.y *= SrgbDecode(128.0f / 255);
  SceneBuilder builder = WallOf(Cloth(vec3(0.0f), vec3(0.5f, 0.25f, 0.0f), 0.8f));
  builder.scene.textures = {UniformTexture(255, 128, 7, 3), UniformTexture(1, 2, 3, 255 / 2 + 1)};
  builder.scene.materials[0].sheen_color_texture.texture = 0;
  builder.scene.materials[0].sheen_roughness_texture.texture = 1;
  ExpectNear(DiffuseAlbedoOf(builder), DiffuseAlbedoOf(expected), 1e-3f);
}

/// A wall that transmits diffuse light, with a directional lamp before or behind it that meets it
/// at an angle of 0.5. \return its light
vec3 LightOfLeaf(const Material& leaf, bool behind) {
  SceneBuilder builder = WallOf(leaf);
  builder.scene.environment.radiance = vec3(0.0f);
  PunctualLight light;
  light.type = LightType::kDirectional;
  light.intensity = vec3(2.0f);
  Transform pose;
  pose.rotation = Rotation(vec3(0, 1, 0), (behind ? kPi : 0.0f) + 0.5f);
  light.node = builder.AddNode(pose);
  builder.scene.lights.push_back(light);
  const Frame frame = RenderOne(builder.scene, SmallSettings(2, 2, 1));
  EXPECT_EQ(Mean(frame.Find(SignalKind::kDirectSpecular)->radiance), vec3(0.0f));
  return Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance);
}

// Lambert on both sides: irradiance times colour over pi.
TEST(DiffuseTransmissionTest, LightOfALampByHand) {
  Material leaf = Lambert(vec3(0.8f, 0.4f, 0.2f));
  leaf.diffuse_transmission = 0.25f;
  leaf.diffuse_transmission_color = vec3(0.6f, 1.0f, 0.1f);
  const float irradiance = 2.0f * std::cos(0.5f) / kPi;
  ExpectNear(LightOfLeaf(leaf, false), irradiance * 0.75f * vec3(leaf.base_color), 1e-5f, "before");
  ExpectNear(LightOfLeaf(leaf, true), irradiance * 0.25f * leaf.diffuse_transmission_color, 1e-5f,
             "behind");
  ExpectNear(DiffuseAlbedoOf(WallOf(leaf)),
             0.75f * vec3(leaf.base_color) + 0.25f * leaf.diffuse_transmission_color, 1e-5f);
}

// Before a constant environment a sheet shows the sum of both albedos, found by all strategies.
TEST(DiffuseTransmissionTest, EnvironmentOnBothSidesByAllStrategies) {
  Material leaf = Lambert(vec3(0.9f));
  leaf.diffuse_transmission = 0.5f;
  leaf.diffuse_transmission_color = vec3(0.2f, 0.6f, 1.0f);
  const SceneBuilder builder = WallOf(leaf);
  for (const LightSampling sampling :
       {LightSampling::kMis, LightSampling::kLight, LightSampling::kBsdf}) {
    const vec3 seen = Mean(RenderMean(builder.scene, SmallSettings(4, 4, 1), 1024, sampling));
    ExpectNear(seen, vec3(0.55f, 0.75f, 0.95f), 0.01f, std::to_string(static_cast<int>(sampling)));
  }
}

// Only the diffuse part is divided: metal and glass transmit as before.
TEST(DiffuseTransmissionTest, LeavesTheOtherLobesAlone) {
  Material metal = Metal(vec3(0.9f), 0.5f);
  const vec3 bare = SpecularAlbedoOf(WallOf(metal));
  metal.diffuse_transmission = 1.0f;
  ExpectNear(SpecularAlbedoOf(WallOf(metal)), bare, 0.0f);
  ExpectNear(DiffuseAlbedoOf(WallOf(metal)), vec3(0.0f), 0.0f);
  Material plastic = Plastic(0.5f);
  const vec3 below = DiffuseAlbedoOf(WallOf(plastic));
  plastic.diffuse_transmission = 0.5f;
  plastic.diffuse_transmission_color = vec3(0.5f);
  ExpectNear(DiffuseAlbedoOf(WallOf(plastic)), 0.75f * below, 1e-5f);
}

// Light that a solid's front transmits is absorbed up to the back: in a thick slab whose front
// scatters and whose back is black, what the floor of the slab would return is zero, and through a
// slab of index 1 without reflection a lamp behind it arrives by Beer's law.
TEST(DiffuseTransmissionTest, SolidsAbsorbOnTheWay) {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 1e-3f;
  Material body = Lambert(vec3(0.0f));
  body.diffuse_transmission = 1.0f;
  body.solid = true;
  body.attenuation_color = vec3(0.5f, 0.8f, 1.0f);
  body.attenuation_distance = 1.0f;
  builder.Add(Quad(vec3(-9, -9, -3), vec3(18, 0, 0), vec3(0, 18, 0)), body);
  PunctualLight light;
  light.type = LightType::kPoint;
  light.intensity = vec3(4.0f);
  light.node = builder.AddNode(At(vec3(0, 0, -5)));  // inside, 2 behind the face
  builder.scene.lights.push_back(light);
  const Frame frame = RenderOne(builder.scene, SmallSettings(2, 2, 1));
  ExpectNear(Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance), vec3(0.25f, 0.64f, 1.0f) / kPi,
             1e-5f);
}

TEST(DiffuseTransmissionTest, TexturesAreAlphaAndSrgbColour) {
  Material leaf = Lambert(vec3(0.0f));
  leaf.diffuse_transmission = 0.5f;
  leaf.diffuse_transmission_color = vec3(0.8f, 0.4f, 0.2f);
  SceneBuilder builder = WallOf(leaf);
  builder.scene.textures = {UniformTexture(1, 2, 3, 51), UniformTexture(255, 128, 0, 9)};
  builder.scene.materials[0].diffuse_transmission_texture.texture = 0;
  builder.scene.materials[0].diffuse_transmission_color_texture.texture = 1;
  ExpectNear(DiffuseAlbedoOf(builder), 0.1f * vec3(0.8f, 0.4f * SrgbDecode(128.0f / 255), 0.0f),
             1e-6f);
}

void ExpectRefused(const Material& material, const std::string& message) {
  const SceneBuilder builder = WallOf(material);
  const auto renderer = Renderer::Create(builder.scene, SmallSettings(2, 2, 1));
  ASSERT_FALSE(renderer.ok()) << message;
  EXPECT_EQ(renderer.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(renderer.status().message(), HasSubstr(message));
}

TEST(MaterialLayersTest, FactorsOutOfRangeAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const auto changed = [](const auto& change) {
    Material material;
    change(&material);
    return material;
  };
  ExpectRefused(changed([&](Material* m) { m->specular = nan; }),
                "specular is nan, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->specular = 1.5f; }),
                "specular is 1.5, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->specular_color.y = -1.0f; }),
                "specular colour is -1, expected 0 to");
  ExpectRefused(changed([&](Material* m) { m->specular_color.z = infinity; }),
                "specular colour is inf, expected 0 to");
  ExpectRefused(changed([&](Material* m) { m->clearcoat = -0.5f; }),
                "clear coat is -0.5, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->clearcoat_roughness = nan; }),
                "clear coat roughness is nan, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->sheen_color.z = 1.25f; }),
                "sheen colour is 1.25, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->sheen_roughness = -1.0f; }),
                "sheen roughness is -1, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->diffuse_transmission = nan; }),
                "diffuse transmission is nan, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->diffuse_transmission_color.x = 2.0f; }),
                "diffuse transmission colour is 2, expected 0 to 1");
  ExpectRefused(changed([&](Material* m) { m->clearcoat_normal_texture.uv_set = 2; }),
                "its clear coat normal texture uses uv set 2, expected 0 or 1");
  ExpectRefused(changed([&](Material* m) { m->specular_texture.texture = 2; }),
                "its specular texture is 2, but there are 0");
}

}  // namespace
}  // namespace stillray::render::layers_test
