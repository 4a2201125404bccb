// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/bsdf_shared.h"

#include <cmath>
#include <string>
#include <vector>

#include "render/surface.h"
#include "test_scenes.h"

namespace stillray::render::bsdf_test {
namespace {

vec3 Tilted(float cosine, float phi = 0.3f) {
  const float sine = std::sqrt(1.0f - cosine * cosine);
  return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

// A surface in the plane z = 0 seen from local direction wo.
Surface FlatSurface(const Material& material, vec3 wo, bool front = true) {
  Surface surface;
  surface.geometric = vec3(0, 0, 1);
  surface.frame = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
  surface.wo = surface.local_wo = wo;
  surface.front = front;
  surface.material = &material;
  surface.base_colour = vec3(material.base_color);
  surface.metallic = material.metallic;
  surface.roughness = material.roughness;
  surface.transmission = material.transmission;
  surface.layered = IsLayered(material);
  surface.layers = LayersOf(material);
  surface.solid = material.solid ? 1 : 0;
  return surface;
}

struct Case {
  std::string name;
  Material material;
  bool front = true;
  double tolerance = 0.01;  // of its albedo
};

std::vector<Case> Cases() {
  std::vector<Case> cases;
  cases.push_back({"lambert", Lambert(vec3(1.0f))});
  for (const float roughness : {0.0f, 0.15f, 0.4f, 0.7f, 1.0f}) {
    cases.push_back({"metal " + std::to_string(roughness), Metal(vec3(1.0f), roughness)});
    Material plastic = Metal(vec3(1.0f), roughness);
    plastic.metallic = 0.0f;
    cases.push_back({"dielectric " + std::to_string(roughness), plastic});
    plastic.specular = 0.6f;
    plastic.specular_color = vec3(4.0f, 2.0f, 0.5f);
    cases.push_back({"coloured dielectric " + std::to_string(roughness), plastic});
    for (const bool front : {true, false}) {
      cases.push_back({"glass " + std::to_string(roughness) + (front ? " in" : " out"),
                       Glass(1.5f, roughness), front});
    }
    Material sheet = Glass(1.5f, roughness);
    sheet.solid = false;
    cases.push_back({"sheet " + std::to_string(roughness), sheet});
    // Coats as rough as what they cover.
    for (Material coated : {Lambert(vec3(1.0f)), Metal(vec3(1.0f), roughness), plastic,
                            Glass(1.5f, roughness), sheet}) {
      coated.roughness = roughness;
      coated.clearcoat = 0.9f;
      coated.clearcoat_roughness = roughness;
      cases.push_back({"coat over number " + std::to_string(cases.size()), coated});
    }
    for (Material leaf : {Lambert(vec3(1.0f)), plastic}) {
      leaf.roughness = roughness;
      leaf.diffuse_transmission = 0.7f;
      leaf.clearcoat = 0.5f;
      leaf.clearcoat_roughness = 0.5f;
      cases.push_back({"leaf number " + std::to_string(cases.size()), leaf});
    }
    for (Material brushed : {Metal(vec3(1.0f), roughness), plastic}) {
      brushed.anisotropy = roughness == 0.15f ? 0.4f : 0.9f;
      brushed.anisotropy_rotation = 1.1f;
      brushed.clearcoat = roughness == 1.0f ? 0.3f : 0.0f;
      brushed.clearcoat_roughness = 0.5f;
      cases.push_back({"brushed number " + std::to_string(cases.size()), brushed});
    }
    // Sheen of any roughness over a surface of any other.
    for (const float sheen : {0.2f, 0.6f, 1.0f}) {
      for (Material cloth : {Lambert(vec3(1.0f)), Metal(vec3(1.0f), roughness), sheet}) {
        cloth.roughness = roughness;
        cloth.sheen_color = vec3(0.9f);
        cloth.sheen_roughness = sheen;
        cloth.clearcoat = sheen == 0.6f ? 0.5f : 0.0f;
        cloth.clearcoat_roughness = 0.5f;
        cases.push_back(
            {"sheen " + std::to_string(sheen) + " over number " + std::to_string(cases.size()),
             cloth});
      }
    }
  }
  return cases;
}

// Films, of which only metals reflect all light.
std::vector<Case> FilmedCases() {
  std::vector<Case> cases;
  for (const float roughness : {0.0f, 0.15f, 0.4f, 0.7f, 1.0f}) {
    Material plastic = Metal(vec3(1.0f), roughness);
    plastic.metallic = 0.0f;
    Material brushed = Metal(vec3(1.0f), roughness);
    brushed.metallic = 0.5f;
    brushed.anisotropy = 0.6f;
    brushed.clearcoat = 0.3f;
    brushed.clearcoat_roughness = 0.5f;
    Material sheet = Glass(1.5f, roughness);
    sheet.solid = false;
    for (Material film :
         {Metal(vec3(1.0f), roughness), plastic, brushed, Glass(1.5f, roughness), sheet}) {
      film.iridescence = 0.9f;
      film.iridescence_ior = 1.6f;
      film.iridescence_thickness_max = 350.0f;
      const std::string name = "film number " + std::to_string(cases.size());
      // The mean over the lobe is that of 16 normals; from within glass, where much is reflected
      // totally, it does not know which of them are shadowed.
      cases.push_back({name, film, true, 0.015});
      cases.push_back({name + " from behind", film, false, film.solid ? 0.08 : 0.015});
    }
  }
  return cases;
}

std::vector<Case> AllCases() {
  std::vector<Case> cases = Cases();
  for (const Case& filmed : FilmedCases()) {
    cases.push_back(filmed);
  }
  return cases;
}

// For all materials here: they share one refractive index, or need no table.
const BsdfTables& Tables() {
  static const BsdfTables kTables = [] {
    Scene scene;
    scene.materials.push_back(Glass(1.5f, 1.0f));
    return BsdfTables(scene, false);
  }();
  return kTables;
}

vec4 RandomPoint(uint32_t i, uint32_t seed) {
  return SobolSample(i & 0xffffu, seed + (i >> 16));
}

TEST(CosSinOfTurnTest, AgreesWithDoublePrecisionAllTheWayRound) {
  constexpr int kSteps = 1 << 16;
  for (int i = 0; i < kSteps; ++i) {
    const float u = static_cast<float>(i) / kSteps;
    const double angle = 2.0 * 3.14159265358979323846 * u;
    const vec2 turn = CosSinOfTurn(u);
    ASSERT_NEAR(turn.x, std::cos(angle), 1.5e-7) << u;
    ASSERT_NEAR(turn.y, std::sin(angle), 1.5e-7) << u;
  }
  EXPECT_EQ(CosSinOfTurn(0.25f), vec2(0.0f, 1.0f));
  EXPECT_NEAR(CosSinOfTurn(0.99999994f).x, 1.0, 1e-7);
}

TEST(BsdfTest, WhiteSurfacesReflectAllLight) {
  for (const Case& c : Cases()) {
    const BsdfTables& tables = Tables();
    for (const float cosine : {0.05f, 0.2f, 0.5f, 0.8f, 1.0f}) {
      const Surface surface = FlatSurface(c.material, Tilted(cosine), c.front);
      const Bsdf bsdf = tables.Make(surface, 0.0f);
      constexpr uint32_t kCount = 16384;
      glm::dvec3 sum(0.0);
      for (uint32_t i = 0; i < kCount; ++i) {
        const BsdfSample s = SampleBsdf(bsdf, surface.local_wo, RandomPoint(i, 1), kAllLobes);
        if (s.kind != kScatterNone) {
          sum += glm::dvec3(s.diffuse + s.specular);
        }
      }
      EXPECT_NEAR(sum.x / kCount, 1.0, 0.01) << c.name << " at cosine " << cosine;
    }
  }
}

TEST(BsdfTest, GuideAlbedosAreWhatTheLobesReflect) {
  for (Case& c : AllCases()) {
    c.material.base_color = vec4(0.8f, 0.4f, 0.1f, 1.0f);
    const BsdfTables& tables = Tables();
    for (const float cosine : {0.1f, 0.4f, 0.9f}) {
      const Surface surface = FlatSurface(c.material, Tilted(cosine), c.front);
      SpecularAlbedo expected;
      const Bsdf bsdf = tables.Make(surface, 0.0f, &expected);
      constexpr uint32_t kCount = 16384;
      glm::dvec3 diffuse(0.0);
      glm::dvec3 specular(0.0);
      for (uint32_t i = 0; i < kCount; ++i) {
        const BsdfSample s = SampleBsdf(bsdf, surface.local_wo, RandomPoint(i, 2), kAllLobes);
        if (s.kind != kScatterNone) {
          diffuse += glm::dvec3(s.diffuse);
          specular += glm::dvec3(s.specular);
        }
      }
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(diffuse[k] / kCount, DiffuseAlbedo(bsdf)[k], c.tolerance)
            << c.name << ' ' << cosine;
        EXPECT_NEAR(specular[k] / kCount, SumOf(expected)[k], c.tolerance)
            << c.name << ' ' << cosine;
      }
    }
  }
}

// Sums over samples of a part of a BSDF, by the side that light comes from.
struct PartSums {
  glm::dvec3 diffuse{0.0};
  glm::dvec3 reflected{0.0};
  glm::dvec3 transmitted{0.0};

  PartSums(const Bsdf& bsdf, vec3 wo, int part) {
    constexpr uint32_t kCount = 16384;
    for (uint32_t i = 0; i < kCount; ++i) {
      const BsdfSample s = SampleBsdf(bsdf, wo, RandomPoint(i, 2), part);
      if (s.kind != kScatterNone) {
        diffuse += glm::dvec3(s.diffuse) / double{kCount};
        (s.wi.z > 0 ? reflected : transmitted) += glm::dvec3(s.specular) / double{kCount};
      }
    }
  }
};

// What glass reflects and all the rest, each sampled by itself, are together the whole.
TEST(BsdfTest, PartsOfGlassAddUpToTheWhole) {
  int glasses = 0;
  for (Case& c : AllCases()) {
    c.material.base_color = vec4(0.8f, 0.4f, 0.1f, 1.0f);
    for (const float transmission : {1.0f, 0.4f}) {
      if (c.material.transmission <= 0.0f) {
        continue;
      }
      c.material.transmission = transmission;
      ++glasses;
      for (const float cosine : {0.1f, 0.4f, 0.9f}) {
        const Surface surface = FlatSurface(c.material, Tilted(cosine), c.front);
        SpecularAlbedo expected;
        const Bsdf bsdf = Tables().Make(surface, 0.0f, &expected);
        const vec3 wo = surface.local_wo;
        const PartSums rest(bsdf, wo, kLobesWithoutReflection);
        const PartSums reflection(bsdf, wo, kReflectionOfGlass);
        EXPECT_EQ(reflection.diffuse, glm::dvec3(0.0));
        EXPECT_EQ(reflection.transmitted, glm::dvec3(0.0));
        for (int k = 0; k < 3; ++k) {
          EXPECT_NEAR(rest.diffuse[k], DiffuseAlbedo(bsdf)[k], c.tolerance) << c.name << cosine;
          EXPECT_NEAR(rest.transmitted[k], expected.transmitted[k], c.tolerance)
              << c.name << ' ' << cosine;
          EXPECT_NEAR(rest.reflected[k] + reflection.reflected[k], expected.reflected[k],
                      c.tolerance)
              << c.name << ' ' << cosine;
        }
        for (const vec3& wi : {Tilted(0.7f, 1.0f), Tilted(-0.7f, 2.0f), Tilted(cosine, kPi)}) {
          const BsdfValue whole = EvaluateBsdf(bsdf, wo, wi, kAllLobes);
          const BsdfValue a = EvaluateBsdf(bsdf, wo, wi, kLobesWithoutReflection);
          const BsdfValue b = EvaluateBsdf(bsdf, wo, wi, kReflectionOfGlass);
          const float tolerance = 1e-5f * (1.0f + MaxComponent(whole.specular));
          EXPECT_NEAR(a.specular.x + b.specular.x, whole.specular.x, tolerance) << c.name;
          EXPECT_NEAR(a.diffuse.x + b.diffuse.x, whole.diffuse.x, 1e-6f) << c.name;
          EXPECT_TRUE(wi.z > 0.0f || b.density == 0.0f) << c.name;
        }
      }
    }
  }
  EXPECT_GT(glasses, 10);
}

// The light of smooth glass has no noise in its parts: a path in each takes the only way.
TEST(BsdfTest, PartsOfSmoothGlassAreConstant) {
  for (const bool solid : {true, false}) {
    Material material = Glass(1.5f, 0.0f);
    material.solid = solid;
    const Surface surface = FlatSurface(material, Tilted(0.3f), true);
    SpecularAlbedo albedo;
    const Bsdf bsdf = Tables().Make(surface, 0.0f, &albedo);
    for (uint32_t i = 0; i < 50; ++i) {
      const vec4 u = RandomPoint(i, 3);
      const BsdfSample through = SampleBsdf(bsdf, surface.local_wo, u, kLobesWithoutReflection);
      const BsdfSample mirrored = SampleBsdf(bsdf, surface.local_wo, u, kReflectionOfGlass);
      EXPECT_NEAR(through.specular.x, albedo.transmitted.x, 1e-6f);
      EXPECT_NEAR(mirrored.specular.x, albedo.reflected.x, 1e-6f);
      EXPECT_LT(through.wi.z, 0.0f);
      EXPECT_EQ(mirrored.kind, kScatterMirror);
    }
  }
}

// Counts samples over the sphere of directions and compares with the integral of the density.
void ExpectDensityOfSamples(int part) {
  constexpr int kRings = 16;
  constexpr int kSectors = 12;
  constexpr int kFine = 24;  // points per edge of a bin
  constexpr uint32_t kCount = 65536;
  for (const Case& c : AllCases()) {
    if (c.material.roughness < 0.4f) {
      continue;  // too narrow for the bins
    }
    if (part != kAllLobes && c.material.transmission <= 0.0f) {
      continue;
    }
    const BsdfTables& tables = Tables();
    const Surface surface = FlatSurface(c.material, Tilted(0.6f), c.front);
    const Bsdf bsdf = tables.Make(surface, 0.0f);
    std::vector<double> observed(kRings * kSectors, 0.0);
    double lost = 0;
    for (uint32_t i = 0; i < kCount; ++i) {
      // Independent numbers, not a low-discrepancy set: the statistic assumes so.
      const auto u = [&](uint32_t d) {
        return FractionToFloat(HashCombine(HashCombine(i, 17), d));
      };
      const BsdfSample s = SampleBsdf(bsdf, surface.local_wo, vec4(u(0), u(1), u(2), u(3)), part);
      if (s.kind == kScatterNone) {
        ++lost;
        continue;
      }
      ASSERT_EQ(s.kind, kScatterRough);
      const int ring = std::min(static_cast<int>((s.wi.z + 1) * 0.5f * kRings), kRings - 1);
      const float turn = std::atan2(s.wi.y, s.wi.x) * 0.5f * kInvPi + 0.5f;
      const int sector = std::min(static_cast<int>(turn * kSectors), kSectors - 1);
      ++observed[static_cast<size_t>(ring * kSectors + sector)];
    }
    double chi2 = 0;
    double total = 0;
    int bins = 0;
    for (int ring = 0; ring < kRings; ++ring) {
      for (int sector = 0; sector < kSectors; ++sector) {
        double density = 0;
        for (int a = 0; a < kFine; ++a) {
          for (int b = 0; b < kFine; ++b) {
            const float z = (ring + (a + 0.5f) / kFine) / kRings * 2 - 1;
            const float phi = ((sector + (b + 0.5f) / kFine) / kSectors - 0.5f) * 2 * kPi;
            density += EvaluateBsdf(bsdf, surface.local_wo, Tilted(z, phi), part).density;
          }
        }
        const double expected = density / (kFine * kFine) * 4 * kPi / (kRings * kSectors) * kCount;
        total += expected;
        const double got = observed[static_cast<size_t>(ring * kSectors + sector)];
        if (expected >= 8) {
          chi2 += (got - expected) * (got - expected) / expected;
          ++bins;
        } else {
          EXPECT_LT(got, 40) << c.name << ": expected " << expected;
        }
      }
    }
    EXPECT_NEAR((total + lost) / kCount, 1.0, 0.01) << c.name;
    // Mean bins, standard deviation sqrt(2 bins); 5 of those, and the error of the bins' integrals.
    EXPECT_LT(chi2, bins + 5 * std::sqrt(2.0 * bins) + 0.1 * bins) << c.name << ", bins " << bins;
  }
}

TEST(BsdfTest, SamplesFollowTheirDensity) {
  ExpectDensityOfSamples(kAllLobes);
}

TEST(BsdfTest, SamplesOfPartsFollowTheirDensity) {
  ExpectDensityOfSamples(kLobesWithoutReflection);
  ExpectDensityOfSamples(kReflectionOfGlass);
}

TEST(BsdfTest, SpecularLobeIsReciprocalUpToCompensation) {
  const Material metal = Metal(vec3(1.0f), 0.6f);
  const BsdfTables& tables = Tables();
  const vec3 a = Tilted(0.3f, 0.1f);
  const vec3 b = Tilted(0.8f, 2.0f);
  const Bsdf from_a = tables.Make(FlatSurface(metal, a), 0.0f);
  const Bsdf from_b = tables.Make(FlatSurface(metal, b), 0.0f);
  const float ab =
      EvaluateBsdf(from_a, a, b, kAllLobes).specular.x / (b.z * from_a.specular_scale.x);
  const float ba =
      EvaluateBsdf(from_b, b, a, kAllLobes).specular.x / (a.z * from_b.specular_scale.x);
  EXPECT_NEAR(ab / ba, 1.0f, 1e-4f);
}

TEST(BsdfTest, BoundaryTransmissionIsReciprocal) {
  // Basic radiance: f(a -> b) cos_b as seen from one side, over n^2 of the other, is symmetric.
  Material glass = Glass(1.5f, 0.6f);
  const BsdfTables& tables = Tables();
  const vec3 outside = Tilted(0.7f, 0.2f);
  const vec3 inside = Tilted(-0.85f, 2.9f);
  const Bsdf in = tables.Make(FlatSurface(glass, outside), 0.0f);
  const Bsdf out = tables.Make(FlatSurface(glass, -inside, false), 0.0f);
  const float forward = EvaluateBsdf(in, outside, inside, kAllLobes).specular.x /
                        (std::abs(inside.z) * in.glass_compensation);
  const float back = EvaluateBsdf(out, -inside, -outside, kAllLobes).specular.x /
                     (std::abs(outside.z) * out.glass_compensation);
  ASSERT_GT(forward, 0.0f);
  EXPECT_NEAR(forward / back, 1.5f * 1.5f, 1e-3f);
}

TEST(GgxTest, VisibleNormalsIntegrateToOne) {
  for (const float alpha : {0.1f, 0.4f, 1.0f}) {
    for (const float cosine : {0.2f, 0.7f, 1.0f}) {
      const vec3 wo = Tilted(cosine);
      constexpr int kSteps = 800;
      double sum = 0;
      for (int i = 0; i < kSteps; ++i) {
        for (int j = 0; j < 64; ++j) {
          const float z = (i + 0.5f) / kSteps;
          sum += GgxVisibleDensity(wo, Tilted(z, (j + 0.5f) / 64 * 2 * kPi), alpha);
        }
      }
      EXPECT_NEAR(sum * 2 * kPi / (kSteps * 64), 1.0, 0.01) << alpha << ' ' << cosine;
    }
  }
}

TEST(GgxTest, SampledNormalsHaveTheMeanOfTheirDensity) {
  const vec3 wo = Tilted(0.5f, 0.0f);
  const float alpha = 0.5f;
  constexpr uint32_t kCount = 16384;
  glm::dvec3 sampled(0.0);
  for (uint32_t i = 0; i < kCount; ++i) {
    const vec4 u = SobolSample(i, 4);
    sampled += glm::dvec3(SampleGgxVisible(wo, alpha, u.x, u.y));
  }
  glm::dvec3 integrated(0.0);
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < 256; ++j) {
      const vec3 h = Tilted((i + 0.5f) / kSteps, (j + 0.5f) / 256 * 2 * kPi);
      integrated += glm::dvec3(h) * static_cast<double>(GgxVisibleDensity(wo, h, alpha));
    }
  }
  integrated *= 2 * kPi / (kSteps * 256.0);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(sampled[k] / kCount, integrated[k], 0.003) << k;
  }
}

TEST(FresnelTest, ValuesWorkedByHand) {
  EXPECT_NEAR(FresnelDielectric(1.0f, 1.5f), 0.04f, 1e-6f);
  EXPECT_NEAR(FresnelDielectric(1.0f, 1.0f / 1.5f), 0.04f, 1e-6f);
  EXPECT_FLOAT_EQ(FresnelDielectric(0.5f, 1.0f / 1.5f), 1.0f);  // sin 0.866 > 1 / 1.5
  // 45 degrees on glass: sin t = 0.4714, cos t = 0.8819;
  // rs = (0.7071 - 1.3229) / (0.7071 + 1.3229) = -0.3034, rp = rs^2 in modulus
  const float rs = 0.3034f * 0.3034f;
  EXPECT_NEAR(FresnelDielectric(0.70710678f, 1.5f), 0.5f * (rs + rs * rs), 1e-4f);
  EXPECT_NEAR(FresnelThinSheet(1.0f, 1.5f), 0.08f / 1.04f, 1e-6f);
  EXPECT_FLOAT_EQ(SchlickWeight(0.5f), 0.03125f);
}

TEST(FresnelTest, RefractionObeysSnell) {
  const vec3 wo = Tilted(0.6f, 0.0f);  // sin = 0.8
  const vec3 wi = RefractAbout(wo, vec3(0, 0, 1), 1.6f);
  EXPECT_NEAR(wi.x, -0.5f, 1e-6f);
  EXPECT_NEAR(wi.z, -std::sqrt(0.75f), 1e-6f);
}

}  // namespace
}  // namespace stillray::render::bsdf_test
