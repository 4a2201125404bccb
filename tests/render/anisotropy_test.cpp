// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// KHR_materials_anisotropy: the lobe, its sampling and its energy, and its direction on meshes.
#include <cmath>
#include <limits>
#include <string>

#include "render/surface.h"
#include "test_scenes.h"

namespace stillray::render::anisotropy_test {
namespace {

using glm::dvec3;
using ::testing::HasSubstr;

constexpr double kExactPi = 3.14159265358979323846;

dvec3 Towards(double cosine, double azimuth) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
}

/// D as glTF writes it, and as Burley (2012, B.3) does.
double ExactD(dvec3 h, double along, double across) {
  const double x = h.x / along;
  const double y = h.y / across;
  const double sum = x * x + y * y + h.z * h.z;
  return 1 / (kExactPi * along * across * sum * sum);
}

/// Heitz (2014), eq. 72 and 86.
double ExactLambda(dvec3 w, double along, double across) {
  const double tan2 = (along * along * w.x * w.x + across * across * w.y * w.y) / (w.z * w.z);
  return (-1 + std::sqrt(1 + tan2)) / 2;
}

/// f cos of a lobe that reflects everything: D G2 / (4 cos_o), eq. 99 for G2.
double ExactLobe(dvec3 wo, dvec3 wi, double along, double across) {
  const double g2 = 1 / (1 + ExactLambda(wo, along, across) + ExactLambda(wi, along, across));
  return ExactD(glm::normalize(wo + wi), along, across) * g2 / (4 * wo.z);
}

TEST(AnisotropicGgxTest, AgreesWithDoublePrecision) {
  for (const vec2& alpha : {vec2(0.5f, 0.1f), vec2(1.0f, 0.02f), vec2(0.3f, 0.3f)}) {
    for (int i = 0; i < 200; ++i) {
      const dvec3 wo = Towards(0.05 + 0.9 * (i % 7) / 7, 0.4 * i);
      const dvec3 wi = Towards(0.05 + 0.9 * (i % 11) / 11, 2.3 * i);
      const GgxValue lobe = EvaluateGgxOf2(alpha, vec3(wo), vec3(wi));
      const double exact = ExactLobe(wo, wi, alpha.x, alpha.y);
      const double density = ExactD(glm::normalize(wo + wi), alpha.x, alpha.y) /
                             (1 + ExactLambda(wo, alpha.x, alpha.y)) / (4 * wo.z);
      EXPECT_NEAR(lobe.value / exact, 1, 1e-4) << alpha.x << ' ' << alpha.y << ' ' << i;
      EXPECT_NEAR(lobe.density / density, 1, 1e-4) << alpha.x << ' ' << alpha.y << ' ' << i;
      EXPECT_NEAR(GgxLambdaOf2(vec3(wo), alpha), ExactLambda(wo, alpha.x, alpha.y), 1e-3);
    }
  }
}

TEST(AnisotropicGgxTest, EqualAlphasAreTheIsotropicLobe) {
  for (const float alpha : {0.05f, 0.3f, 1.0f}) {
    for (int i = 0; i < 50; ++i) {
      const vec3 wo(Towards(0.1 + 0.017 * i, 0.7 * i));
      const vec3 wi(Towards(0.95 - 0.015 * i, 1.9 * i));
      const GgxValue lobe = EvaluateGgxOf2(vec2(alpha), wo, wi);
      const GgxValue isotropic = EvaluateGgx(alpha, wo, wi);
      EXPECT_NEAR(lobe.value / isotropic.value, 1.0f, 1e-5f);
      EXPECT_NEAR(lobe.density / isotropic.density, 1.0f, 1e-5f);
      EXPECT_EQ(lobe.schlick, isotropic.schlick);
      const vec3 h = SampleGgxVisibleOf2(wo, vec2(alpha), 0.3f, 0.6f);
      EXPECT_EQ(h, SampleGgxVisible(wo, alpha, 0.3f, 0.6f));
    }
  }
}

// The projected area of all microfacets is that of the surface.
TEST(AnisotropicGgxTest, DistributionIsNormalised) {
  for (const vec2& alpha : {vec2(0.8f, 0.2f), vec2(1.0f, 0.1f)}) {
    constexpr int kSteps = 1000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double cosine = (i + 0.5) / kSteps;
        const vec3 h(Towards(cosine, (j + 0.5) / kSteps * kExactPi / 2));
        // Straight ahead the lobe is D / (4 (cos + Lambda's)): take D out of the density.
        const GgxValue lobe = EvaluateGgxOf2(alpha, h, h);
        const double d = lobe.density * 4 * h.z * (1 + ExactLambda(h, alpha.x, alpha.y));
        sum += d * cosine;
      }
    }
    EXPECT_NEAR(sum * 2 * kExactPi / (kSteps * kSteps), 1, 1e-3) << alpha.y;
  }
}

// alpha_t = mix(alpha, 1, strength^2), alpha_b = alpha.
TEST(AnisotropicGgxTest, AlphasOfTheExtension) {
  const vec2 alpha = AnisotropicAlpha(0.09f, 0.6f, 0.0f);
  EXPECT_NEAR(alpha.x, 0.09f + 0.91f * 0.36f, 1e-6f);
  EXPECT_EQ(alpha.y, 0.09f);
  EXPECT_EQ(AnisotropicAlpha(0.09f, 0.0f, 0.0f), vec2(0.09f));
  EXPECT_EQ(AnisotropicAlpha(0.0f, 0.0f, 0.0f), vec2(0.0f));
  EXPECT_EQ(AnisotropicAlpha(0.0f, 1.0f, 0.0f), vec2(1.0f, kSmoothAlpha)) << "no ideal mirror";
  EXPECT_EQ(AnisotropicAlpha(0.0f, 0.01f, 0.0f), vec2(0.0f)) << "narrower than is resolved";
  EXPECT_EQ(AnisotropicAlpha(0.1f, 0.5f, 0.2f), vec2(0.325f, 0.2f)) << "regularised";
}

Material Brushed(float roughness, float strength, float rotation) {
  Material metal = Metal(vec3(1.0f), roughness);
  metal.anisotropy = strength;
  metal.anisotropy_rotation = rotation;
  return metal;
}

Surface FlatSurface(const Material& material, vec3 wo) {
  Surface surface;
  surface.geometric = vec3(0, 0, 1);
  surface.frame = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
  surface.wo = surface.local_wo = wo;
  surface.front = 1;
  surface.solid = 0;
  surface.material = &material;
  surface.base_colour = vec3(material.base_color);
  surface.metallic = material.metallic;
  surface.roughness = material.roughness;
  surface.layered = IsLayered(material);
  surface.layers = LayersOf(material);
  return surface;
}

const BsdfTables& Tables() {
  static const BsdfTables kTables(Scene(), false);
  return kTables;
}

// Strength 0 is the isotropic material, to the last bit.
TEST(AnisotropyTest, WithoutStrengthItIsTheIsotropicMaterial) {
  for (const float roughness : {0.0f, 0.4f, 1.0f}) {
    for (const float least : {0.0f, 0.25f}) {
      const vec3 wo(Towards(0.6, 1));
      const vec3 wi(Towards(0.7, 4));
      const Material turned = Brushed(roughness, 0.0f, 0.7f);
      EXPECT_FALSE(IsLayered(turned));
      Surface surface = FlatSurface(turned, wo);
      SpecularAlbedo albedo;
      const Bsdf plain = Tables().Make(surface, least, &albedo);
      surface.layered = true;
      SpecularAlbedo same_albedo;
      const Bsdf same = Tables().Make(surface, least, &same_albedo);
      EXPECT_EQ(EvaluateBsdf(same, wo, wi, kAllLobes).specular,
                EvaluateBsdf(plain, wo, wi, kAllLobes).specular);
      EXPECT_EQ(EvaluateBsdf(same, wo, wi, kAllLobes).density,
                EvaluateBsdf(plain, wo, wi, kAllLobes).density);
      EXPECT_EQ(SampleBsdf(same, wo, vec4(0.3f), kAllLobes).wi,
                SampleBsdf(plain, wo, vec4(0.3f), kAllLobes).wi);
      EXPECT_EQ(SumOf(same_albedo), SumOf(albedo));
    }
  }
}

TEST(AnisotropyTest, LobeIsReciprocalUpToCompensation) {
  const Material metal = Brushed(0.4f, 0.8f, 0.5f);
  const vec3 a(Towards(0.3, 0.1));
  const vec3 b(Towards(0.8, 2.0));
  const Bsdf from_a = Tables().Make(FlatSurface(metal, a), 0.0f);
  const Bsdf from_b = Tables().Make(FlatSurface(metal, b), 0.0f);
  const float ab =
      EvaluateBsdf(from_a, a, b, kAllLobes).specular.x / (b.z * from_a.specular_scale.x);
  const float ba =
      EvaluateBsdf(from_b, b, a, kAllLobes).specular.x / (a.z * from_b.specular_scale.x);
  ASSERT_GT(ab, 0.0f);
  EXPECT_NEAR(ab / ba, 1.0f, 1e-4f);
}

/// The part of the light that a white lobe reflects, over the visible normals in double precision.
double ExactAlbedo(dvec3 wo, double along, double across) {
  // Stretched to alpha 1, visible normals are spread evenly over a tilted spherical cap.
  const dvec3 w = glm::normalize(dvec3(along * wo.x, across * wo.y, wo.z));
  constexpr int kSteps = 400;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double phi = 2 * kExactPi * (i + 0.5) / kSteps;
      const double z = 1 - (j + 0.5) / kSteps * (1 + w.z);
      const double r = std::sqrt(1 - z * z);
      const dvec3 n = dvec3(r * std::cos(phi), r * std::sin(phi), z) + w;
      const dvec3 h = glm::normalize(dvec3(along * n.x, across * n.y, n.z));
      const dvec3 wi = 2 * glm::dot(wo, h) * h - wo;
      if (wi.z > 0) {
        const double lambda = ExactLambda(wo, along, across);
        sum += (1 + lambda) / (1 + lambda + ExactLambda(wi, along, across));
      }
    }
  }
  return sum / (kSteps * kSteps);
}

// Away from the table's entries. Half a percent on average; at grazing angles, for lobes that are
// smooth in one direction, two.
TEST(AnisotropyTest, TableOfAlbedosIsTheIntegralOfTheLobe) {
  double total = 0;
  int count = 0;
  for (const double cosine : {0.07, 0.33, 0.72, 1.0}) {
    for (const double azimuth : {0.0, 0.5, 1.3, 2.0, 1.57079632}) {
      for (const vec2& alpha : {vec2(0.55f, 0.04f), vec2(0.9f, 0.3f), vec2(0.2f, 0.15f)}) {
        const dvec3 wo = Towards(cosine, azimuth);
        const SchlickShare share = AnisotropicEnergyTables().Lookup(vec3(wo), alpha);
        const double exact = ExactAlbedo(wo, alpha.x, alpha.y);
        EXPECT_NEAR(share.scale + share.offset, exact, 0.02)
            << cosine << ' ' << azimuth << ' ' << alpha.x << ' ' << alpha.y;
        total += std::abs(share.scale + share.offset - exact);
        ++count;
      }
    }
  }
  EXPECT_LT(total / count, 0.005);
}

TEST(AnisotropyTest, TableContainsTheIsotropicOne) {
  const SpecularEnergy& isotropic = SpecularEnergyTables();
  for (const float cosine : {0.2f, 0.5f, 0.9f}) {
    for (const float roughness : {0.3f, 0.6f, 1.0f}) {
      const vec3 wo(Towards(cosine, 0.4));
      const SchlickShare share = AnisotropicEnergyTables().Lookup(wo, vec2(roughness * roughness));
      const EnergyTable::Place at = EnergyTable::Find(cosine, roughness);
      EXPECT_NEAR(share.scale, isotropic.scale.Lookup(at), 0.01) << cosine << ' ' << roughness;
      EXPECT_NEAR(share.offset, isotropic.offset.Lookup(at), 0.01) << cosine << ' ' << roughness;
    }
  }
}

/// A wall of 18 x 18 before the camera; its u runs to the right, its v up.
SceneBuilder WallOf(const Material& material, const Transform& pose = {}) {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 1e-3f;
  builder.Add(Quad(vec3(-9, -9, -3), vec3(18, 0, 0), vec3(0, 18, 0)), material, pose);
  return builder;
}

/// The light of the wall by a directional lamp in the direction `wi`.
float LightOf(SceneBuilder builder, dvec3 wi) {
  PunctualLight light;
  light.type = LightType::kDirectional;
  light.intensity = vec3(1.0f);
  Transform pose;  // shines along -z
  const vec3 axis = glm::cross(vec3(0, 0, 1), vec3(wi));
  pose.rotation = Rotation(glm::normalize(axis), static_cast<float>(std::acos(wi.z)));
  light.node = builder.AddNode(pose);
  builder.scene.lights.push_back(light);
  const Frame frame = RenderOne(builder.scene, SmallSettings(2, 2, 1));
  return Mean(frame.Find(SignalKind::kDirectSpecular)->radiance).x;
}

/// Expects the lobe to be stretched along `angle` from x to y, by the ratio of two lamps.
void ExpectStretched(const SceneBuilder& builder, double angle, const std::string& what) {
  const double roughness = builder.scene.materials[0].roughness;
  const double strength = builder.scene.materials[0].anisotropy;
  const double across = roughness * roughness;
  const double along = across + (1 - across) * strength * strength;
  const dvec3 wo(0, 0, 1);
  const dvec3 lamps[] = {Towards(0.8, 0.4), Towards(0.8, 1.9)};
  double expected[2];
  float found[2];
  for (int i = 0; i < 2; ++i) {
    const double azimuth = std::atan2(lamps[i].y, lamps[i].x) - angle;
    expected[i] = ExactLobe(wo, Towards(lamps[i].z, azimuth), along, across);
    found[i] = LightOf(builder, lamps[i]);
  }
  EXPECT_NEAR(found[0] / found[1] / (expected[0] / expected[1]), 1, 1e-3) << what;
}

Texture UniformTexture(uint8_t r, uint8_t g, uint8_t b) {
  Texture texture;
  texture.width = texture.height = 1;
  texture.texels = {r, g, b, 255};
  return texture;
}

// The bitangent is up in the texture: where v decreases.
TEST(AnisotropyTest, DirectionFollowsTheMesh) {
  SceneBuilder by_uv = WallOf(Brushed(0.5f, 0.7f, 0.0f));
  ExpectStretched(by_uv, 0.0, "u");
  by_uv.scene.materials[0].anisotropy_rotation = 0.3f;
  ExpectStretched(by_uv, -0.3, "u, turned");
  SceneBuilder by_tangents = by_uv;
  by_tangents.scene.meshes[0].tangents.assign(4, vec4(0, 1, 0, 1));
  ExpectStretched(by_tangents, kExactPi / 2 + 0.3, "tangents");
  by_tangents.scene.meshes[0].tangents.assign(4, vec4(0, 1, 0, -1));
  ExpectStretched(by_tangents, kExactPi / 2 - 0.3, "left-handed tangents");
  Transform mirror;
  mirror.scale = vec3(-1, 1, 1);
  SceneBuilder mirrored = WallOf(Brushed(0.5f, 0.7f, 0.3f), mirror);
  ExpectStretched(mirrored, 0.3, "mirrored");
  SceneBuilder second = by_uv;
  second.scene.meshes[0].uv[1] = {vec2(0, 1), vec2(0, 0), vec2(1, 0), vec2(1, 1)};
  second.scene.textures = {UniformTexture(255, 128, 255)};
  second.scene.materials[0].anisotropy_texture = {0, 1, mat3(1.0f)};
  ExpectStretched(second, kExactPi / 2 - 0.3 - std::atan(1 / 255.0), "second set");
}

TEST(AnisotropyTest, TextureIsDirectionAndStrength) {
  SceneBuilder builder = WallOf(Brushed(0.5f, 0.9f, 0.25f));
  builder.scene.meshes[0].tangents.assign(4, vec4(1, 0, 0, 1));
  SceneBuilder expected = builder;
  expected.scene.materials[0].anisotropy *= 102.0f / 255;
  expected.scene.materials[0].anisotropy_rotation += std::atan2(201 - 127.5f, 51 - 127.5f);
  builder.scene.textures = {UniformTexture(51, 201, 102)};
  builder.scene.materials[0].anisotropy_texture.texture = 0;
  for (const double azimuth : {0.2, 1.0, 2.9}) {
    const float found = LightOf(builder, Towards(0.7, azimuth));
    EXPECT_NEAR(found / LightOf(expected, Towards(0.7, azimuth)), 1.0f, 1e-4f) << azimuth;
  }
}

TEST(AnisotropyTest, WithoutADirectionItIsIsotropic) {
  SceneBuilder builder = WallOf(Brushed(0.5f, 0.9f, 0.0f));
  builder.scene.meshes[0].uv[0].clear();
  const SceneBuilder plain = WallOf(Metal(vec3(1.0f), 0.5f));
  const dvec3 wi = Towards(0.7, 1.0);
  EXPECT_NEAR(LightOf(builder, wi) / LightOf(plain, wi), 1.0f, 1e-5f);
}

// The side that is seen from behind is stretched in the same direction.
TEST(AnisotropyTest, BothSidesOfASheetAreAlike) {
  Transform turned;
  turned.rotation = Rotation(vec3(0, 1, 0), kPi);
  turned.translation = vec3(0, 0, -6);
  SceneBuilder builder = WallOf(Brushed(0.5f, 0.7f, 0.0f), turned);
  builder.scene.meshes[0].tangents.assign(4, vec4(std::cos(0.4f), std::sin(0.4f), 0, 1));
  ExpectStretched(builder, -0.4, "behind");
}

// Mean alphas of lobes are geometric: that of an isotropic lobe of the same height.
TEST(AnisotropyTest, RoughnessGuideIsOfAnIsotropicLobeOfTheSameHeight) {
  const Frame frame = RenderOne(WallOf(Brushed(0.5f, 0.6f, 0.0f)).scene, SmallSettings(1, 1, 1));
  const float along = 0.25f + 0.75f * 0.36f;
  EXPECT_NEAR(frame.guides.roughness(0, 0), std::pow(along * 0.25f, 0.25f), 1e-5f);
}

// In a white environment a white metal is as bright as it, by all ways of finding light.
TEST(AnisotropyTest, WhiteMetalVanishesInAWhiteFurnace) {
  SceneBuilder builder = WallOf(Brushed(0.3f, 0.9f, 0.4f));
  builder.scene.environment.radiance = vec3(1.0f);
  builder.CameraTransform().rotation = Rotation(vec3(0, 1, 0), 1.0f);
  for (const LightSampling sampling :
       {LightSampling::kMis, LightSampling::kLight, LightSampling::kBsdf}) {
    const vec3 seen = Mean(RenderMean(builder.scene, SmallSettings(4, 4, 1), 1024, sampling));
    ExpectNear(seen, vec3(1.0f), 0.015f, std::to_string(static_cast<int>(sampling)));
  }
}

TEST(AnisotropyTest, ValuesOutOfRangeAreRefused) {
  const auto message = [](const Material& material) {
    const auto renderer = Renderer::Create(WallOf(material).scene, SmallSettings(2, 2, 1));
    EXPECT_EQ(renderer.status().code(), StatusCode::kInvalidArgument);
    return renderer.status().message();
  };
  EXPECT_THAT(message(Brushed(0.5f, 1.5f, 0.0f)), HasSubstr("anisotropy is 1.5, expected 0 to 1"));
  EXPECT_THAT(message(Brushed(0.5f, 1.0f, std::numeric_limits<float>::infinity())),
              HasSubstr("anisotropy rotation is inf, expected a number"));
}

}  // namespace
}  // namespace stillray::render::anisotropy_test
