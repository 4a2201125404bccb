// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// KHR_materials_volume_scatter: free paths, phase function, and bodies against analytic and
// independently simulated ones.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "render/medium_shared.h"
#include "render/path_shared.h"
#include "test_scenes.h"

namespace stillray::render::volume_test {
namespace {

using glm::dvec3;
using ::testing::HasSubstr;

constexpr double kExactPi = 3.14159265358979323846;

/// Of a half space in diffuse light (van de Hulst 1974, as d'Eon writes it).
double MultiScatterAlbedo(double single) {
  const double s = std::sqrt(1 - single);
  return (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s);
}

double ExactSingleScatterAlbedo(double multi) {
  const double s =
      4.09712 + 4.20863 * multi - std::sqrt(9.59217 + 41.6808 * multi + 17.7126 * multi * multi);
  return 1 - s * s;
}

TEST(MediumTest, SingleScatterAlbedoIsTheExtensions) {
  for (int i = 0; i <= 20; ++i) {
    const double multi = i / 20.0;
    const double single = SingleScatterAlbedo(static_cast<float>(multi));
    EXPECT_NEAR(single, ExactSingleScatterAlbedo(multi), 1e-5) << multi;
    EXPECT_NEAR(MultiScatterAlbedo(single), multi, 1e-3) << multi;
  }
  EXPECT_GE(SingleScatterAlbedo(0.0f), 0.0f);
  EXPECT_LE(SingleScatterAlbedo(1.0f), 1.0f);
}

/// Calls `use` with flights for points spread evenly over the unit square.
template <typename Use>
void ForFlights(vec3 extinction, vec3 albedo, vec3 share, float far, const Use& use) {
  constexpr int kChoices = 300;
  constexpr int kDepths = 4000;
  for (int i = 0; i < kChoices; ++i) {
    for (int j = 0; j < kDepths; ++j) {
      use(FlyThrough(extinction, albedo, share, far, (i + 0.5f) / kChoices, (j + 0.5f) / kDepths),
          1.0 / (kChoices * kDepths));
    }
  }
}

// exp(-extinction x) gets to x, for every colour whatever the choice of one; a part of the rest is
// absorbed.
TEST(MediumTest, FreePathsFollowTheTransmittance) {
  const vec3 extinction(0.3f, 1.2f, 4.0f);
  const vec3 albedo(0.9f, 0.5f, 0.0f);
  constexpr float kEnd = 2.0f;
  constexpr int kBins = 8;
  for (const vec3& share :
       {vec3(1.0f), vec3(0.2f, 0.7f, 0.1f), vec3(0.0f), vec3(5.0f, 1.0f, 0.5f)}) {
    std::vector<dvec3> collided(kBins, dvec3(0.0));
    dvec3 passed(0.0);
    ForFlights(extinction, albedo, share, kEnd, [&](const Flight& flight, double part) {
      if (flight.collides == 0) {
        passed += part * dvec3(flight.weight);
        return;
      }
      ASSERT_LT(flight.distance, kEnd);
      collided[static_cast<size_t>(flight.distance / kEnd * kBins)] += part * dvec3(flight.weight);
    });
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(passed[c], std::exp(-extinction[c] * kEnd), 1e-3) << c;
      for (int bin = 0; bin < kBins; ++bin) {
        const double from = std::exp(-extinction[c] * kEnd * bin / kBins);
        const double to = std::exp(-extinction[c] * kEnd * (bin + 1) / kBins);
        EXPECT_NEAR(collided[static_cast<size_t>(bin)][c], albedo[c] * (from - to), 2e-3)
            << bin << ' ' << c;
      }
    }
  }
}

TEST(MediumTest, FreePathsEndWhereThereIsNoMedium) {
  const Flight far = FlyThrough(vec3(0.0f, 2.0f, 2.0f), vec3(1.0f), vec3(1.0f, 0.0f, 0.0f),
                                kInfinity, 0.5f, 0.9999f);
  EXPECT_EQ(far.collides, 0);
  EXPECT_EQ(far.weight, vec3(1.0f, 0.0f, 0.0f));
  const Flight clear = FlyThrough(vec3(0.0f), vec3(1.0f), vec3(1.0f), 7.0f, 0.5f, 0.9999f);
  EXPECT_EQ(clear.collides, 0);
  EXPECT_EQ(clear.weight, vec3(1.0f));
}

/// The phase function of Henyey and Greenstein by the cosine of the deflection.
double ExactPhase(double cosine, double g) {
  return (1 - g * g) / (4 * kExactPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

TEST(MediumTest, DeflectionsFollowThePhaseFunction) {
  for (const float g : {-0.95f, -0.4f, 0.0f, 5e-4f, 2e-3f, 0.3f, 0.8f, 0.99f}) {
    constexpr int kCount = 1 << 18;
    constexpr int kBins = 16;
    double mean = 0;
    std::vector<double> found(kBins, 0.0);
    for (int i = 0; i < kCount; ++i) {
      const float cosine = SampleDeflection(g, (i + 0.5f) / kCount);
      ASSERT_TRUE(cosine >= -1.0f && cosine <= 1.0f);
      mean += cosine / double{kCount};
      found[std::min(static_cast<size_t>((cosine + 1) / 2 * kBins), size_t{kBins - 1})] +=
          1.0 / kCount;
    }
    EXPECT_NEAR(mean, g, 1e-3) << g;
    double total = 0;
    for (int bin = 0; bin < kBins; ++bin) {
      constexpr int kSteps = 100000;
      double expected = 0;
      for (int k = 0; k < kSteps; ++k) {
        const double cosine = -1 + 2 * (bin + (k + 0.5) / kSteps) / kBins;
        expected += ExactPhase(cosine, g) * 2 * kExactPi * 2 / (kBins * double{kSteps});
      }
      EXPECT_NEAR(found[static_cast<size_t>(bin)], expected, 2e-3) << g << ' ' << bin;
      total += expected;
    }
    EXPECT_NEAR(total, 1, 1e-4) << "normalised " << g;
  }
}

TEST(MediumTest, ScatteringIsAroundTheDirectionOfFlight) {
  const vec3 direction = glm::normalize(vec3(0.3f, -0.8f, 0.5f));
  constexpr int kTurns = 64;
  dvec3 mean(0.0);
  for (int i = 0; i < kTurns; ++i) {
    const vec3 onward = SampleScattering(direction, 0.7f, 0.4f, (i + 0.5f) / kTurns);
    EXPECT_NEAR(length(onward), 1.0f, 1e-5f);
    EXPECT_NEAR(dot(onward, direction), SampleDeflection(0.7f, 0.4f), 1e-5f);
    mean += dvec3(onward) / double{kTurns};
  }
  const double cosine = SampleDeflection(0.7f, 0.4f);
  ExpectNear(vec3(mean), vec3(dvec3(direction) * cosine), 1e-4f, "no side is preferred");
}

/// A path that has entered a medium of albedo 1 in which it collides almost at once.
PathState PathInMilk() {
  PathState path = StartPath(1);
  path.first = 0;
  path.light = kLightDirect;
  path.density = 2.0f;
  path.diffuse = vec3(1.0f);
  path.extinction = vec3(1000.0f);
  path.scatter_albedo = vec3(1.0f);
  return path;
}

/// CrossMedium over a distance of 1, with the least number for Russian roulette.
int Cross(PathState* path, int most_bounces) {
  vec3 direction(0, 0, 1);
  float distance = 0.0f;
  return CrossMedium(*path, 1.0f, vec4(0.5f), 0.0f, most_bounces, direction, distance);
}

TEST(MediumTest, CollisionsCountAsOneBounceUpToTheirLimit) {
  PathState path = PathInMilk();
  for (int i = 1; i <= kMaxCollisions; ++i) {
    ASSERT_EQ(Cross(&path, 1), kMediumScatters) << i;
    ASSERT_EQ(path.collisions, i);
    ASSERT_EQ(path.bounces, 1);
  }
  EXPECT_EQ((path.light & kLightDirect), 0);
  EXPECT_EQ(path.density, 0.0f) << "no light is sampled at collisions";
  ExpectNear(path.throughput, vec3(1.0f), 1e-4f, "nothing is absorbed");
  EXPECT_EQ(Cross(&path, 1), kMediumEnds);
}

TEST(MediumTest, WithoutABouncePathsEndAtCollisions) {
  PathState path = PathInMilk();
  path.bounces = 2;
  EXPECT_EQ(Cross(&path, 2), kMediumEnds);
}

TEST(MediumTest, PathsThatPassAMediumKeepTheirStrategy) {
  PathState path = PathInMilk();
  path.extinction = vec3(1e-3f);
  EXPECT_EQ(Cross(&path, 0), kMediumPasses);
  EXPECT_EQ((path.light & kLightDirect), 1);
  EXPECT_EQ(path.density, 2.0f);
  EXPECT_EQ(path.bounces, 0);
  EXPECT_EQ(path.collisions, 0);
}

/// A body of refractive index `ior` with the attenuation `transmittance` per unit length.
Material Scattering(float ior, vec3 multiscatter, float anisotropy, vec3 transmittance) {
  Material material = Glass(ior, 0.0f);
  material.multiscatter_color = multiscatter;
  material.scatter_anisotropy = anisotropy;
  material.attenuation_color = transmittance;
  material.attenuation_distance = 1.0f;
  return material;
}

/// The same behind a surface of diffuse transmission alone.
Material Waxen(vec3 multiscatter, float anisotropy, vec3 transmittance) {
  Material material = Scattering(1.0f, multiscatter, anisotropy, transmittance);
  material.transmission = 0.0f;
  material.roughness = 1.0f;
  material.diffuse_transmission = 1.0f;
  return material;
}

RenderSettings DeepSettings(int width = 24, int height = 24) {
  RenderSettings settings = SmallSettings(width, height, 1);
  settings.bounces = 32;
  settings.jitter = true;
  return settings;
}

/// A sphere that fills most of the picture, in an environment of 1.
SceneBuilder BodyInFurnace(const Material& material) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(1.0f);
  builder.scene.cameras[0].yfov = 0.5f;
  builder.Add(FacetedSphere(vec3(0, 0, -5), 1.2f, 3), material);
  return builder;
}

// Without absorption a body vanishes. Behind a boundary that reflects it must be dense: thin glass
// traps light, by total reflection, until the limit of free events.
TEST(VolumeTest, WhiteBodiesVanishInAFurnace) {
  const vec3 white(1.0f);
  const vec3 thin(0.8f, 0.4f, 0.1f);
  const vec3 dense(0.2f, 0.1f, 0.05f);
  for (const Material& material :
       {Scattering(1.0f, white, 0.0f, thin), Scattering(1.0f, white, 0.7f, thin),
        Scattering(1.5f, white, 0.0f, dense), Scattering(1.3f, white, -0.5f, vec3(0.05f)),
        Waxen(white, 0.0f, thin), Waxen(white, 0.5f, vec3(0.1f))}) {
    const vec3 mean = Mean(RenderMean(BodyInFurnace(material).scene, DeepSettings(), 256));
    ExpectNear(mean, vec3(1.0f), 0.006f,
               std::to_string(material.ior) + ' ' + std::to_string(material.scatter_anisotropy));
  }
}

/// Chandrasekhar's H function of isotropic scattering by iteration.
double HFunction(double cosine, double albedo) {
  constexpr int kNodes = 400;
  static std::vector<double> h(kNodes, 1.0);
  static double of_albedo = -1;
  const auto value = [&](double mu) {
    double sum = 0;
    for (int k = 0; k < kNodes; ++k) {
      const double node = (k + 0.5) / kNodes;
      sum += node * h[static_cast<size_t>(k)] / (mu + node) / kNodes;
    }
    return 1 / (std::sqrt(1 - albedo) + albedo / 2 * sum);
  };
  if (of_albedo != albedo) {
    h.assign(kNodes, 1.0);
    for (int iteration = 0; iteration < 400; ++iteration) {
      std::vector<double> next(kNodes);
      for (int k = 0; k < kNodes; ++k) {
        next[static_cast<size_t>(k)] = value((k + 0.5) / kNodes);
      }
      h = next;
    }
    of_albedo = albedo;
  }
  return value(cosine);
}

/// A slab before the camera, so wide that its edges do not matter, seen at `angle`.
SceneBuilder Slab(const Material& material, float thickness, float angle) {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 1e-3f;
  builder.CameraTransform().rotation = Rotation(vec3(0, 1, 0), angle);
  builder.Add(Box(vec3(-400, -400, -1 - thickness), vec3(400, 400, -1)), material);
  return builder;
}

double ExactReflectance(double cosine, double eta) {
  const double sine2 = (1 - cosine * cosine) / (eta * eta);
  if (sine2 >= 1) {
    return 1;
  }
  const double below = std::sqrt(1 - sine2);
  const double s = (cosine - eta * below) / (cosine + eta * below);
  const double p = (eta * cosine - below) / (eta * cosine + below);
  return (s * s + p * p) / 2;
}

/// The part of light perpendicularly onto a slab of isotropic scattering without absorption that is
/// reflected from inside more often than the limit of free events, in double precision.
double SimulateTrapped(double ior, double depth) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  constexpr int kPhotons = 200000;
  int trapped = 0;
  for (int i = 0; i < kPhotons; ++i) {
    if (uniform(engine) < ExactReflectance(1, ior)) {
      continue;
    }
    double z = 0;
    double mu = 1;
    int free_events = 1;
    while (true) {
      const double far = (mu > 0 ? depth - z : -z) / mu;
      const double flight = -std::log(1 - uniform(engine));
      if (flight < far) {
        z += mu * flight;
        mu = 2 * uniform(engine) - 1;
        continue;
      }
      if (++free_events > kMaxFreeEvents) {
        ++trapped;
        break;
      }
      if (uniform(engine) >= ExactReflectance(std::abs(mu), 1 / ior)) {
        break;
      }
      z = mu > 0 ? depth : 0;
      mu = -mu;
    }
  }
  return trapped / double{kPhotons};
}

TEST(VolumeTest, ThinGlassLosesTheLightThatItTraps) {
  SceneBuilder builder = Slab(Scattering(1.5f, vec3(1.0f), 0.0f, vec3(0.8f)), 1.0f, 0.0f);
  builder.scene.environment.radiance = vec3(1.0f);
  const vec3 mean = Mean(RenderMean(builder.scene, DeepSettings(16, 16), 256));
  const double trapped = SimulateTrapped(1.5, -std::log(0.8));
  EXPECT_GT(trapped, 0.005);
  ExpectNear(mean, vec3(static_cast<float>(1 - trapped)), 0.002f);
}

// In uniform light a half space of isotropic scattering, without a boundary, has the radiance
// 1 - H(mu) sqrt(1 - albedo) (Chandrasekhar 1960, by reciprocity). Each colour has its own albedo
// and extinction: they share free paths, and not results.
TEST(VolumeTest, HalfSpaceHasChandrasekharsAlbedo) {
  const vec3 multi(0.7f, 0.4f, 0.15f);
  for (const float angle : {0.0f, 1.0f}) {
    SceneBuilder builder =
        Slab(Scattering(1.0f, multi, 0.0f, vec3(0.1f, 0.4f, 0.02f)), 30.0f, angle);
    builder.scene.environment.radiance = vec3(1.0f);
    const vec3 seen = Mean(RenderMean(builder.scene, DeepSettings(16, 16), 256));
    for (int c = 0; c < 3; ++c) {
      const double albedo = ExactSingleScatterAlbedo(multi[c]);
      const double expected = 1 - HFunction(std::cos(angle), albedo) * std::sqrt(1 - albedo);
      EXPECT_NEAR(seen[c], expected, 0.012) << angle << ' ' << c;
    }
  }
}

struct SlabLight {
  double reflected = 0;
  double transmitted = 0;
};

/// Simulates photons through a slab in double precision: the parts that leave on either side.
SlabLight SimulateSlab(double albedo, double g, double depth, double cosine) {
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  constexpr int kPhotons = 200000;
  SlabLight light;
  for (int i = 0; i < kPhotons; ++i) {
    double z = 0;
    dvec3 w(std::sqrt(1 - cosine * cosine), 0, cosine);
    while (true) {
      z -= std::log(1 - uniform(engine)) * w.z;
      if (z < 0 || z > depth) {
        (z < 0 ? light.reflected : light.transmitted) += 1.0 / kPhotons;
        break;
      }
      if (uniform(engine) > albedo) {
        break;
      }
      // Rejection from the phase function needs none of its inverse.
      dvec3 onward;
      double phase;
      const double most = ExactPhase(g > 0 ? 1 : -1, g);
      do {
        const double mu = 2 * uniform(engine) - 1;
        const double phi = 2 * kExactPi * uniform(engine);
        onward = {std::sqrt(1 - mu * mu) * std::cos(phi), std::sqrt(1 - mu * mu) * std::sin(phi),
                  mu};
        phase = ExactPhase(glm::dot(onward, w), g);
      } while (uniform(engine) * most > phase);
      w = onward;
    }
  }
  return light;
}

// A lamp of radiance 1 behind the slab, or before it (the environment of the camera's side).
TEST(VolumeTest, SlabsTransmitAndReflectAsPhotonsDo) {
  const vec3 multi(0.8f, 0.6f, 0.3f);
  for (const float g : {0.0f, 0.6f, -0.5f}) {
    for (const float angle : {0.0f, 0.9f}) {
      const vec3 depth(2.0f, 0.7f, 1.4f);
      SceneBuilder builder = Slab(Scattering(1.0f, multi, g, glm::exp(-depth)), 1.0f, angle);
      SceneBuilder behind = builder;
      behind.Add(Quad(vec3(-900, -900, -2.5f), vec3(1800, 0, 0), vec3(0, 1800, 0)),
                 Emitter(vec3(1.0f)));
      SceneBuilder before = builder;
      before.scene.environment.radiance = vec3(1.0f);
      before.Add(Quad(vec3(-900, -900, -2.5f), vec3(1800, 0, 0), vec3(0, 1800, 0)),
                 Lambert(vec3(0.0f)));
      const vec3 transmitted = Mean(RenderMean(behind.scene, DeepSettings(16, 16), 256));
      const vec3 reflected = Mean(RenderMean(before.scene, DeepSettings(16, 16), 256));
      for (int c = 0; c < 3; ++c) {
        const SlabLight expected =
            SimulateSlab(ExactSingleScatterAlbedo(multi[c]), g, depth[c], std::cos(angle));
        EXPECT_NEAR(transmitted[c], expected.transmitted, 0.012) << g << ' ' << angle << ' ' << c;
        EXPECT_NEAR(reflected[c], expected.reflected, 0.012) << g << ' ' << angle << ' ' << c;
      }
    }
  }
}

// Where next to nothing is scattered, sampled free paths are Beer's law in the mean; where nothing
// is, there are none.
TEST(VolumeTest, WithoutScatteringLightIsAbsorbed) {
  const vec3 transmittance(0.7f, 0.4f, 0.1f);
  const auto picture = [&](vec3 multi) {
    SceneBuilder builder = Slab(Scattering(1.0f, multi, 0.0f, transmittance), 1.0f, 0.0f);
    builder.Add(Quad(vec3(-900, -900, -2.5f), vec3(1800, 0, 0), vec3(0, 1800, 0)),
                Emitter(vec3(1.0f)));
    return Mean(RenderMean(builder.scene, DeepSettings(16, 16), 256));
  };
  ExpectNear(picture(vec3(0.0f)), transmittance, 1e-4f, "none");
  ExpectNear(picture(vec3(1e-5f)), transmittance, 0.01f, "little");
}

// Only one colour is scattered: the others are absorbed by the same paths.
TEST(VolumeTest, ColoursAreApart) {
  const vec3 multi(0.0f, 0.6f, 0.0f);
  SceneBuilder builder = Slab(Scattering(1.0f, multi, 0.0f, vec3(0.5f)), 30.0f, 0.0f);
  builder.scene.environment.radiance = vec3(1.0f);
  const vec3 seen = Mean(RenderMean(builder.scene, DeepSettings(16, 16), 64));
  EXPECT_NEAR(seen.x, 0.0f, 1e-5f);
  EXPECT_GT(seen.y, 0.4f);
  EXPECT_NEAR(seen.z, 0.0f, 1e-5f);
}

// All collisions are one bounce: with the fewest a body is as bright as with many.
TEST(VolumeTest, CollisionsAreOneBounce) {
  SceneBuilder builder = BodyInFurnace(Scattering(1.0f, vec3(0.6f), 0.0f, vec3(0.05f)));
  RenderSettings settings = DeepSettings();
  const vec3 many = Mean(RenderMean(builder.scene, settings, 64));
  settings.bounces = 1;
  const vec3 one = Mean(RenderMean(builder.scene, settings, 64));
  EXPECT_LT(many.x, 0.97f);
  ExpectNear(one, many, 0.005f);
}

// Lamps without extent light a body through its boundary's diffuse transmission.
TEST(VolumeTest, PunctualLightsReachBodiesOfDiffuseTransmission) {
  SceneBuilder builder = Slab(Waxen(vec3(0.9f), 0.0f, vec3(0.2f)), 1.0f, 0.0f);
  PunctualLight light;
  light.type = LightType::kDirectional;
  light.intensity = vec3(3.0f);
  light.node = builder.AddNode({});  // shines along -z, onto the face before the camera
  builder.scene.lights.push_back(light);
  const Frame frame = RenderOne(builder.scene, SmallSettings(16, 16, 64));
  // Nothing is reflected by the face itself: what is seen has been inside.
  EXPECT_EQ(Mean(frame.Find(SignalKind::kDirectDiffuse)->radiance), vec3(0.0f));
  EXPECT_GT(Mean(frame.Find(SignalKind::kIndirectDiffuse)->radiance).x, 0.05f);
  EXPECT_EQ(Mean(frame.Find(SignalKind::kIndirectSpecular)->radiance), vec3(0.0f));
}

// Scattered light is indirect, light that passes is direct; behind glass both are transmitted.
TEST(VolumeTest, ScatteredLightIsIndirectTransmissionBehindGlass) {
  SceneBuilder builder = Slab(Scattering(1.0f, vec3(0.8f), 0.0f, vec3(0.25f)), 1.0f, 0.0f);
  builder.Add(Quad(vec3(-900, -900, -2.5f), vec3(1800, 0, 0), vec3(0, 1800, 0)),
              Emitter(vec3(1.0f)));
  const Frame frame = RenderOne(builder.scene, SmallSettings(16, 16, 256));
  const double depth = -std::log(0.25);
  const SlabLight all = SimulateSlab(ExactSingleScatterAlbedo(0.8), 0, depth, 1);
  const float scattered = Mean(frame.Find(SignalKind::kIndirectTransmission)->radiance).x;
  const float passed = Mean(frame.Find(SignalKind::kDirectTransmission)->radiance).x;
  EXPECT_NEAR(scattered + passed, all.transmitted, 0.015);
  EXPECT_GT(scattered, 0.05f);
  EXPECT_EQ(Mean(frame.Find(SignalKind::kIndirectDiffuse)->radiance), vec3(0.0f));
}

// What is seen through clear glass has virtual guides; a medium that scatters hides it.
TEST(VolumeTest, GuidesEndAtTheSurface) {
  const auto has_image = [](vec3 multi) {
    SceneBuilder builder = Slab(Scattering(1.4f, multi, 0.0f, vec3(0.9f)), 1.0f, 0.0f);
    builder.Add(Quad(vec3(-900, -900, -2.5f), vec3(1800, 0, 0), vec3(0, 1800, 0)),
                Lambert(vec3(0.5f)));
    builder.scene.environment.radiance = vec3(1.0f);
    RenderSettings settings = SmallSettings(4, 4, 1);
    settings.virtual_guides = true;
    const Frame frame = RenderOne(builder.scene, settings);
    return !frame.refraction.empty() && frame.refraction.depth(2, 2) > 0.0f;
  };
  EXPECT_TRUE(has_image(vec3(0.0f)));
  EXPECT_FALSE(has_image(vec3(0.5f)));
}

TEST(VolumeTest, ValuesOutOfRangeAreRefused) {
  const auto message = [](vec3 multi, float g) {
    const Material material = Scattering(1.3f, multi, g, vec3(0.5f));
    const auto renderer = Renderer::Create(BodyInFurnace(material).scene, SmallSettings(2, 2, 1));
    EXPECT_EQ(renderer.status().code(), StatusCode::kInvalidArgument);
    return renderer.status().message();
  };
  EXPECT_THAT(message(vec3(0.5f, 1.5f, 0.0f), 0.0f),
              HasSubstr("multi-scatter colour is 1.5, expected 0 to 1"));
  EXPECT_THAT(message(vec3(0.5f), 1.0f),
              HasSubstr("scatter anisotropy is 1, expected more than -1"));
  EXPECT_THAT(message(vec3(0.5f), std::numeric_limits<float>::quiet_NaN()),
              HasSubstr("scatter anisotropy is nan"));
}

}  // namespace
}  // namespace stillray::render::volume_test
