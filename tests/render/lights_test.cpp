// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/lights.h"

#include <cmath>

#include "render/alias_table.h"
#include "test_scenes.h"

namespace stillray::render::lights_test {
namespace {

AliasChoice Choose(const std::vector<AliasEntry>& table, float u) {
  const AliasColumn column = FindAliasColumn(static_cast<uint32_t>(table.size()), u);
  return ChooseInColumn(column, table[column.index]);
}

TEST(AliasTableTest, DrawsInProportion) {
  const std::vector<float> weights = {1.0f, 0.0f, 5.0f, 0.25f, 3.75f, 0.0f};
  std::vector<AliasEntry> table(weights.size());
  FillAliasTable(weights.data(), weights.size(), table.data());
  constexpr int kCount = 100000;
  std::vector<int> counts(weights.size(), 0);
  double rest = 0;
  for (int i = 0; i < kCount; ++i) {
    const AliasChoice choice = Choose(table, (static_cast<float>(i) + 0.5f) / kCount);
    ASSERT_GE(choice.rest, 0.0f);
    ASSERT_LT(choice.rest, 1.0f);
    rest += choice.rest;
    ++counts[choice.index];
  }
  for (size_t i = 0; i < weights.size(); ++i) {
    EXPECT_NEAR(counts[i] / static_cast<double>(kCount), weights[i] / 10.0, 1e-3) << i;
    EXPECT_FLOAT_EQ(table[i].probability, weights[i] / 10.0f);
  }
  EXPECT_NEAR(rest / kCount, 0.5, 1e-3);
}

TEST(AliasTableTest, NothingToDrawGivesNoProbability) {
  const float weights[2] = {0.0f, 0.0f};
  AliasEntry table[2];
  FillAliasTable(weights, 2, table);
  EXPECT_EQ(table[0].probability, 0.0f);
  EXPECT_EQ(table[1].probability, 0.0f);
}

TEST(PunctualTest, FormulasWorkedByHand) {
  EXPECT_FLOAT_EQ(RangeAttenuation(1.0f, 2.0f), 0.9375f);
  EXPECT_FLOAT_EQ(RangeAttenuation(2.0f, 2.0f), 0.0f);
  EXPECT_FLOAT_EQ(RangeAttenuation(3.0f, 2.0f), 0.0f);
  EXPECT_FLOAT_EQ(RangeAttenuation(3.0f, std::numeric_limits<float>::infinity()), 1.0f);
  EXPECT_FLOAT_EQ(SpotAttenuation(0.95f, 0.9f, 0.5f), 1.0f);
  EXPECT_FLOAT_EQ(SpotAttenuation(0.7f, 0.9f, 0.5f), 0.25f);
  EXPECT_FLOAT_EQ(SpotAttenuation(0.4f, 0.9f, 0.5f), 0.0f);
}

// A floor at y = 0, seen from above at (x, 0, 0); the light at (0, height, 0) shines down.
float RadianceUnder(PunctualLight light, float height, float x) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(x, 5, 0));
  builder.CameraTransform().rotation = Rotation(vec3(1, 0, 0), -kPi / 2);
  builder.scene.cameras[0].yfov = 1e-3f;
  builder.Add(Quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  Transform down = At(vec3(0, height, 0));
  down.rotation = Rotation(vec3(1, 0, 0), -kPi / 2);
  light.node = builder.AddNode(down);
  builder.scene.lights.push_back(light);
  const Frame frame = RenderOne(builder.scene, SmallSettings(1, 1, 4));
  return Mean(SumOfLight(frame)).x * kPi / 0.5f;  // irradiance
}

TEST(PunctualTest, PointLightFallsOffWithTheSquare) {
  PunctualLight light;
  light.intensity = vec3(3.0f);
  EXPECT_NEAR(RadianceUnder(light, 1.0f, 0.0f), 3.0f, 1e-3f);
  EXPECT_NEAR(RadianceUnder(light, 2.0f, 0.0f), 0.75f, 1e-3f);
  EXPECT_NEAR(RadianceUnder(light, 1.0f, 1.0f), 3.0f / 2 / std::sqrt(2.0f), 1e-3f);
  light.range = 2.0f;
  EXPECT_NEAR(RadianceUnder(light, 1.0f, 0.0f), 3.0f * 0.9375f, 1e-3f);
}

TEST(PunctualTest, SpotLightHasACone) {
  PunctualLight light;
  light.type = LightType::kSpot;
  light.intensity = vec3(4.0f);
  light.inner_cone_angle = 0.3f;
  light.outer_cone_angle = 0.6f;
  EXPECT_NEAR(RadianceUnder(light, 1.0f, 0.0f), 4.0f, 1e-3f);
  const float angle = 0.5f;
  const float ramp = (std::cos(angle) - std::cos(0.6f)) / (std::cos(0.3f) - std::cos(0.6f));
  const float c = std::cos(angle);
  EXPECT_NEAR(RadianceUnder(light, 1.0f, std::tan(angle)), 4.0f * ramp * ramp * c * c * c, 2e-3f);
  EXPECT_EQ(RadianceUnder(light, 1.0f, std::tan(0.7f)), 0.0f);
}

TEST(PunctualTest, DirectionalLightDoesNotFallOff) {
  PunctualLight light;
  light.type = LightType::kDirectional;
  light.intensity = vec3(1.25f);
  EXPECT_NEAR(RadianceUnder(light, 1.0f, 0.0f), 1.25f, 1e-3f);
  EXPECT_NEAR(RadianceUnder(light, 4.0f, 3.0f), 1.25f, 1e-3f);
}

Environment SpottedEnvironment() {
  Environment environment;
  environment.radiance = vec3(2.0f);
  environment.map = Image3(16, 8);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 16; ++x) {
        environment.map[c](x, y) =
            (x * 7 + y * 3) % 5 == 0 ? 0.0f : 0.1f * static_cast<float>(x + y);
      }
    }
    environment.map[c](15, 2) = 30.0f;
  }
  return environment;
}

TEST(EnvironmentTest, DensityIntegratesToOneAndSamplesEstimateTheMean) {
  const Environment environment = SpottedEnvironment();
  const EnvironmentLight light(environment);
  const vec3 normal(0, 1, 0);
  double density = 0;
  double luminance = 0;
  constexpr int kRows = 512;
  constexpr int kColumns = 1024;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const float theta = (y + 0.5f) / kRows * kPi;
      const float phi = (x + 0.5f) / kColumns * 2 * kPi;
      const vec3 d(std::sin(theta) * std::sin(phi), std::cos(theta),
                   -std::sin(theta) * std::cos(phi));
      const double solid =
          std::sin(theta) * 2 * kPi * kPi / (kRows * static_cast<double>(kColumns));
      density += EnvironmentDensity(light.arrays(), normal, d) * solid;
      luminance += Luminance709(light.Radiance(d)) * solid;
    }
  }
  EXPECT_NEAR(density, 1.0, 2e-3);
  EXPECT_NEAR(luminance / (4 * kPi) / light.arrays().mean_luminance, 1.0, 0.02);
  double estimate = 0;
  constexpr uint32_t kCount = 16384;
  for (uint32_t i = 0; i < kCount; ++i) {
    const vec4 u = SobolSample(i, 8);
    const EnvironmentSample s = SampleEnvironment(light.arrays(), normal, u.x, u.y);
    ASSERT_NEAR(glm::length(s.direction), 1.0f, 1e-5f);
    ASSERT_GT(s.density, 0.0f);
    estimate += Luminance709(s.radiance) / s.density;
  }
  EXPECT_NEAR(estimate / kCount / luminance, 1.0, 0.01);
}

TEST(AnglesTest, PolynomialsOfTheShaders) {
  for (int i = -1000; i <= 1000; ++i) {
    const double angle = i * M_PI / 1000;
    const auto x = static_cast<float>(std::cos(angle));
    const auto y = static_cast<float>(std::sin(angle));
    EXPECT_NEAR(PolynomialArcTangent(y, x), std::atan2(double{y}, double{x}), 5e-7) << i;
    EXPECT_NEAR(PolynomialArcCosine(x), std::acos(double{x}), 5e-7) << i;
  }
  EXPECT_EQ(PolynomialArcTangent(0, 0), 0.0f);
  EXPECT_FLOAT_EQ(PolynomialArcTangent(1, 0), kPi / 2);
  EXPECT_FLOAT_EQ(PolynomialArcTangent(-2, 0), -kPi / 2);
  EXPECT_FLOAT_EQ(PolynomialArcTangent(0, -3), kPi);
}

TEST(EnvironmentTest, MapIsTheRightWayRound) {
  Environment environment;
  environment.radiance = vec3(1.0f);
  environment.map = Image3(4, 3);
  environment.map[0](2, 1) = 8.0f;  // just right of the middle: -z, towards +x
  environment.map[1](0, 0) = 4.0f;  // top row
  const EnvironmentLight light(environment);
  const float middle = 3.14159265f / 4;  // centre of texel 2
  EXPECT_NEAR(light.Radiance(vec3(std::sin(middle), 0, -std::cos(middle))).x, 8.0f, 1e-3f);
  EXPECT_NEAR(light.Radiance(vec3(-std::sin(middle), 0, -std::cos(middle))).x, 0.0f, 1e-3f);
  EXPECT_GT(light.Radiance(vec3(-0.01f, 1, 0.01f)).y, 3.0f);
  EXPECT_EQ(light.Radiance(vec3(-0.01f, -1, 0.01f)).y, 0.0f);
}

// Draws lights for a point and compares with the densities that a ray finds.
TEST(LightSetTest, DensitiesOfRaysAreThoseOfSamples) {
  SceneBuilder builder;
  for (int i = 0; i < 40; ++i) {
    const float a = static_cast<float>(i);
    builder.Add(FacetedSphere(vec3(3 * std::sin(a), std::cos(a), -5 - 0.2f * a), 0.3f, 1),
                Emitter(vec3(1.0f + a)));
  }
  const Material bright = Emitter(vec3(2.0f));
  builder.Add(Quad(vec3(-2, 4, -4), vec3(4, 0, 0), vec3(0, 0, 3)), bright);
  builder.scene.environment.radiance = vec3(0.3f);
  SceneState state(builder.scene);
  state.Update(0, 0);
  LightSet lights(state);
  lights.Update(true);
  const vec3 point(0.5f, -1, -2);
  const vec3 normal(0, 1, 0);
  const LightChoices choices = WeighLights(lights.arrays(), point);
  const float total = TotalOf(choices);
  // The total flux estimated from samples must equal the sum over all triangles.
  double estimate = 0;
  constexpr uint32_t kCount = 65536;
  for (uint32_t i = 0; i < kCount; ++i) {
    const vec4 u = SobolSample(i, 21);
    const LightSample s = lights.Sample(point, normal, choices, u);
    if (s.density > 0.0f && std::isfinite(s.distance)) {
      estimate += s.radiance.x / s.density;
    } else if (s.density > 0.0f) {
      EXPECT_NEAR(DensityOfEnvironment(lights.arrays(), normal, total, s.direction) / s.density,
                  1.0f, 1e-3f);
    }
  }
  double exact = 0;  // radiance times solid angle of all triangles that face the point
  for (uint32_t i = 0; i < builder.scene.instances.size(); ++i) {
    const PlacedInstance& instance = state.instance(i);
    for (uint32_t p = 0; p < instance.mesh->indices.size() / 3; ++p) {
      const Triangle t = state.TriangleOf(instance, p);
      const vec3 a = glm::normalize(t.p0 - point);
      const vec3 b = glm::normalize(t.p1 - point);
      const vec3 c = glm::normalize(t.p2 - point);
      const float volume = glm::dot(a, glm::cross(b, c));
      // Seen from the front, corners run counter-clockwise: the volume is negative.
      if (volume < 0) {
        exact += 2 * std::atan2(-volume, 1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a)) *
                 instance.material->emission.x;
      }
    }
  }
  EXPECT_NEAR(estimate / kCount / exact, 1.0, 0.01);
}

TEST(LightSetTest, RayAndSampleAgreeOnDensity) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-1, 2, -3), vec3(2, 0, 0), vec3(0, 0, 1)), Emitter(vec3(2.0f)));
  builder.Add(Quad(vec3(-1, 2, -9), vec3(2, 0, 0), vec3(0, 0, 1)), Emitter(vec3(5.0f)));
  SceneState state(builder.scene);
  state.Update(0, 0);
  LightSet lights(state);
  lights.Update(true);
  const vec3 point(0.2f, -1, -2);
  const LightChoices choices = WeighLights(lights.arrays(), point);
  const float total = TotalOf(choices);
  int compared = 0;
  for (uint32_t i = 0; i < 64; ++i) {
    const LightSample s = lights.Sample(point, vec3(0, 1, 0), choices, SobolSample(i, 2));
    ASSERT_GT(s.density, 0.0f);
    // Which triangle it was follows from the point.
    const uint32_t instance = s.point.z > -4.0f ? 0 : 1;
    const vec3 q = s.point - state.TriangleOf(state.instance(instance), 0).p0;
    const uint32_t primitive = q.z > 0.5f * q.x ? 1 : 0;
    const Hit hit{s.distance, 0, 0, instance, primitive};
    EXPECT_NEAR(lights.DensityOfHit(point, total, hit, s.direction, s.distance) / s.density, 1.0f,
                1e-3f);
    ++compared;
  }
  EXPECT_EQ(compared, 64);
}

TEST(LightSetTest, MovingLampsAreFollowed) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 5, 0));
  builder.CameraTransform().rotation = Rotation(vec3(1, 0, 0), -kPi / 2);
  builder.scene.cameras[0].yfov = 1e-3f;
  builder.Add(Quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  const int lamp = builder.Add(Quad(vec3(-0.1f, 0, -0.1f), vec3(0.2f, 0, 0), vec3(0, 0, 0.2f)),
                               Emitter(vec3(100.0f)), At(vec3(1, 1, 0)));
  builder.Move(builder.InstanceNode(lamp), vec3(2, 0, 0));
  auto renderer = Renderer::Create(builder.scene, SmallSettings(2, 2, 256));
  ASSERT_TRUE(renderer.ok());
  for (const double seconds : {0.0, 1.0, 0.5}) {
    Frame frame;
    RenderMoment moment;
    moment.seconds = seconds;
    ASSERT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
    // Small lamp: L A cos^2 / d^2.
    const double d2 = 1 + std::pow(1 + 2 * seconds, 2);
    const double expected = 0.5 / kPi * 100.0 * 0.04 / (d2 * d2);
    EXPECT_NEAR(Mean(SumOfLight(frame)).x / expected, 1.0, 0.02) << seconds;
  }
}

}  // namespace
}  // namespace stillray::render::lights_test
