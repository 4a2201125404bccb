// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// KHR_materials_iridescence: the film's reflectance against integrals over the spectrum, its
// energy, and films on surfaces.
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <string>

#include "render/surface.h"
#include "test_scenes.h"

namespace stillray::render::iridescence_test {
namespace {

using glm::dvec3;
using ::testing::HasSubstr;

constexpr double kExactPi = 3.14159265358979323846;

vec3 Towards(float cosine, float azimuth) {
  const float sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine};
}

double Squared(double x) {
  return x * x;
}

/// Unpolarised, by Snell's law and Fresnel's formulas.
double ExactFresnel(double cosine, double ior) {
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  const double s = (cosine - ior * inside) / (cosine + ior * inside);
  const double p = (ior * cosine - inside) / (ior * cosine + inside);
  return (s * s + p * p) / 2;
}

/// A film of two faces with reflectances as the extension has them.
struct ExactFilm {
  double path;   // optical path difference, in metres
  double outer;  // amplitudes: negative where light is reversed
  double inner;
};

ExactFilm MakeExactFilm(double cosine, double ior, double thickness, double f0) {
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  const double base = (1 + std::sqrt(f0)) / (1 - std::sqrt(f0));
  const double inner_f0 = Squared((base - ior) / (base + ior));
  const double weight = std::pow(1 - inside, 5);
  const double inner = inner_f0 + (std::min(50 * inner_f0, 1.0) - inner_f0) * weight;
  return {2 * ior * thickness * 1e-9 * inside, -std::sqrt(ExactFresnel(cosine, ior)),
          (base > ior ? -1 : 1) * std::sqrt(inner)};
}

/// Airy's sum of all reflections for light of this wavenumber (1 / wavelength).
double AiryReflectance(const ExactFilm& film, double wavenumber) {
  const std::complex<double> turn =
      std::exp(std::complex<double>(0, 2 * kExactPi * film.path * wavenumber));
  return std::norm((film.outer + film.inner * turn) / (1.0 + film.outer * film.inner * turn));
}

double Bell(double x, double mean, double deviation) {
  return std::exp(-Squared((x - mean) / deviation) / 2);
}

/// The colour matching functions whose Fourier transforms the paper uses. That of a Gaussian of
/// variance 2 v is one of exp(-v phase^2).
dvec3 PaperMatching(double wavenumber) {
  const auto lobe = [&](double value, double position, double v) {
    return value / std::sqrt(2.0) * Bell(wavenumber, position, std::sqrt(2 * v));
  };
  return {lobe(5.4856e-13, 1.6810e6, 4.3278e9) + lobe(9.7470e-14, 2.2399e6, 4.5282e9),
          lobe(4.4201e-13, 1.7953e6, 9.3046e9), lobe(5.2481e-13, 2.2084e6, 6.6121e9)};
}

/// Those of the CIE's standard observer of 1931 by wavelength, as Wyman, Sloan and Shirley (2013,
/// "Simple Analytic Approximations to the CIE XYZ Color Matching Functions") fit them; an integral
/// over wavenumbers needs the square of the wavelength.
dvec3 CieMatching(double wavenumber) {
  const double nm = 1e9 / wavenumber;
  const auto lobe = [&](double height, double mean, double below, double above) {
    return height * Bell(nm, mean, nm < mean ? below : above);
  };
  const dvec3 xyz(lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) -
                      lobe(0.065, 501.1, 20.4, 26.2),
                  lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
                  lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8));
  return xyz * (nm * nm);
}

/// Linear sRGB of light that a film reflects, where light that is the same at all wavelengths is
/// white.
dvec3 ExactColour(const ExactFilm& film, const std::function<dvec3(double)>& matching) {
  const glm::dmat3 to_srgb(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259,
                           -0.4985314, 0.0415560, 1.0572252);
  dvec3 sum(0.0);
  dvec3 white(0.0);
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const double wavenumber = 1.1e6 + 1.8e6 * (i + 0.5) / kSteps;
    sum += matching(wavenumber) * AiryReflectance(film, wavenumber);
    white += matching(wavenumber);
  }
  const dvec3 rgb = to_srgb * sum / (to_srgb * white);
  return glm::clamp(rgb, 0.0, 1.0);
}

/// A bound of what the reflections behind the second one add.
double RestOf(const ExactFilm& film) {
  const double around = std::abs(film.outer * film.inner);
  return 2 * std::pow(around, 3) / (1 - around);
}

/// Calls `check` for films over bases of all kinds with the colour they reflect.
template <typename Check>
void ForFilms(const Check& check) {
  for (const double ior : {1.15, 1.3, 1.6, 2.0}) {
    for (const double thickness : {10.0, 120.0, 250.0, 400.0, 800.0, 2000.0}) {
      for (const double cosine : {0.1, 0.3, 0.6, 1.0}) {
        const FilmView view = ViewFilm(static_cast<float>(cosine), static_cast<float>(ior),
                                       static_cast<float>(thickness));
        for (const double f0 : {0.0, 0.04, 0.3, 0.7, 0.95}) {
          const std::string what = std::to_string(ior) + ", " + std::to_string(thickness) +
                                   " nm at " + std::to_string(cosine) + " over " +
                                   std::to_string(f0);
          check(MakeExactFilm(cosine, ior, thickness, f0),
                FilmReflectance(view, vec3(static_cast<float>(f0))), what);
        }
      }
    }
  }
}

// The series ends behind the second reflection: its rest is small but where both faces reflect
// much, at grazing angles on metals.
TEST(FilmTest, IsTheIntegralOfTheAirySumOverThePapersColours) {
  double total = 0;
  int count = 0;
  ForFilms([&](const ExactFilm& film, vec3 found, const std::string& what) {
    const dvec3 exact = ExactColour(film, PaperMatching);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(found[c], exact[c], 2e-3 + 1.3 * RestOf(film)) << what << " channel " << c;
      total += std::abs(found[c] - exact[c]);
      ++count;
    }
  });
  EXPECT_LT(total / count, 0.006);
}

TEST(FilmTest, HasTheColoursOfTheStandardObserver) {
  double total = 0;
  int count = 0;
  ForFilms([&](const ExactFilm& film, vec3 found, const std::string& what) {
    const dvec3 exact = ExactColour(film, CieMatching);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(found[c], exact[c], 0.06 + 1.3 * RestOf(film)) << what << " channel " << c;
      total += std::abs(found[c] - exact[c]);
      ++count;
    }
  });
  EXPECT_LT(total / count, 0.012);
}

// A quarter wave of magnesium fluoride on glass: ((1.52 - 1.38^2) / (1.52 + 1.38^2))^2 = 0.0126 at
// 550 nm, against 0.0426 without.
TEST(FilmTest, QuarterWaveIsAnAntireflectionCoating) {
  const float bare = 0.04258f;
  const vec3 coated = FilmReflectance(ViewFilm(1.0f, 1.38f, 550 / (4 * 1.38f)), vec3(bare));
  EXPECT_NEAR(coated.y, 0.0126f, 0.0015f);
  EXPECT_GT(coated.x, coated.y) << "purple";
  EXPECT_GT(coated.z, coated.y);
}

// Where a face separates media that are alike there is no film.
TEST(FilmTest, OfAirOrOfTheBasesMediumIsThePlainSurface) {
  for (const float cosine : {0.05f, 0.2f, 0.5f, 0.9f, 1.0f}) {
    for (const float thickness : {50.0f, 400.0f, 900.0f}) {
      const FilmView air = ViewFilm(cosine, 1.0f, thickness);
      for (const float f0 : {0.04f, 0.5f, 1.0f}) {
        const float s = SchlickWeight(cosine);
        const vec3 found = FilmReflectance(air, vec3(f0));
        ExpectNear(found, vec3(f0 * (1 - s) + s), 3e-4f, "air over " + std::to_string(f0));
      }
      const vec3 same =
          FilmReflectance(ViewFilm(cosine, 1.5f, thickness), vec3(DielectricF0(1.5f)));
      ExpectNear(same, vec3(FresnelDielectric(cosine, 1.5f)), 1e-5f, "glass");
    }
  }
}

// r = (n - 1) / (n + 1) of the base whatever lies on it.
TEST(FilmTest, WithoutThicknessIsThePlainSurface) {
  for (const float ior : {1.1f, 1.3f, 1.8f}) {
    for (const float f0 : {0.02f, 0.04f, 0.3f, 0.9f}) {
      const vec3 found = FilmReflectance(ViewFilm(1.0f, ior, 0.0f), vec3(f0));
      ExpectNear(found, vec3(f0), 0.01f, std::to_string(ior) + ' ' + std::to_string(f0));
      EXPECT_NEAR(found.x, found.z, 1e-5f) << "without colour";
    }
  }
}

Material Filmed(Material material, float ior, float thickness) {
  material.iridescence = 1.0f;
  material.iridescence_ior = ior;
  material.iridescence_thickness_max = thickness;
  return material;
}

Surface FlatSurface(const Material& material, vec3 wo, bool front = true) {
  Surface surface;
  surface.geometric = vec3(0, 0, 1);
  surface.frame = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
  surface.wo = surface.local_wo = wo;
  surface.front = front ? 1 : 0;
  surface.solid = material.solid ? 1 : 0;
  surface.material = &material;
  surface.base_colour = vec3(material.base_color);
  surface.metallic = material.metallic;
  surface.roughness = material.roughness;
  surface.transmission = material.transmission;
  surface.layered = IsLayered(material);
  surface.layers = LayersOf(material);
  return surface;
}

const BsdfTables& Tables() {
  static const BsdfTables kTables = [] {
    Scene scene;
    scene.materials.push_back(Glass(1.5f, 1.0f));
    return BsdfTables(scene, false);
  }();
  return kTables;
}

/// The light that a surface scatters in a white furnace.
dvec3 Furnace(const Material& material, float cosine, bool front = true) {
  const Surface surface = FlatSurface(material, Towards(cosine, 0.3f), front);
  const Bsdf bsdf = Tables().Make(surface, 0.0f);
  constexpr uint32_t kCount = 8192;
  dvec3 sum(0.0);
  for (uint32_t i = 0; i < kCount; ++i) {
    const BsdfSample s = SampleBsdf(bsdf, surface.local_wo, SobolSample(i, 3), kAllLobes);
    if (s.kind != kScatterNone) {
      sum += dvec3(s.diffuse + s.specular);
    }
  }
  return sum / double{kCount};
}

// What lies below a film gets what the film leaves of the channel that it reflects most.
TEST(IridescenceTest, WhiteSurfacesLoseNoLightButTheFilmsColour) {
  for (const float roughness : {0.0f, 0.2f, 0.5f, 1.0f}) {
    Material sheet = Glass(1.5f, roughness);
    sheet.solid = false;
    Material leaf = Plastic(roughness);
    leaf.diffuse_transmission = 0.6f;
    leaf.clearcoat = 0.3f;
    Material brushed = Metal(vec3(1.0f), roughness);
    brushed.anisotropy = 0.8f;
    Material coloured = Plastic(roughness);
    coloured.specular = 0.7f;
    coloured.specular_color = vec3(6.0f, 3.0f, 1.0f);
    int number = 0;
    for (const Material& base : {Metal(vec3(1.0f), roughness), Plastic(roughness), sheet, leaf,
                                 brushed, coloured, Glass(1.5f, roughness)}) {
      for (const float thickness : {150.0f, 380.0f, 700.0f}) {
        for (const float cosine : {0.1f, 0.4f, 0.9f}) {
          for (const bool front : {true, false}) {
            const dvec3 sum = Furnace(Filmed(base, 1.7f, thickness), cosine, front);
            const std::string what = std::to_string(number) + " rough " +
                                     std::to_string(roughness) + ", " + std::to_string(thickness) +
                                     " nm at " + std::to_string(cosine) + (front ? "" : " behind");
            const double most = std::max(sum.x, std::max(sum.y, sum.z));
            EXPECT_LT(most, base.solid ? 1.03 : 1.015) << what;
            EXPECT_GT(most, 0.97) << what;
          }
        }
      }
      ++number;
    }
  }
}

TEST(IridescenceTest, LobeIsTheFilmTimesTheWhiteLobe) {
  const vec3 wo = Towards(0.5f, 0.2f);
  const vec3 wi = Towards(0.8f, 2.5f);
  const Material gold = Filmed(Metal(vec3(0.9f, 0.6f, 0.2f), 0.5f), 1.4f, 350.0f);
  const Material white = Metal(vec3(1.0f), 0.5f);
  const Bsdf bsdf = Tables().Make(FlatSurface(gold, wo), 0.0f);
  const Bsdf plain = Tables().Make(FlatSurface(white, wo), 0.0f);
  const vec3 lobe = EvaluateBsdf(bsdf, wo, wi, kAllLobes).specular / bsdf.specular_scale;
  const vec3 all = EvaluateBsdf(plain, wo, wi, kAllLobes).specular / plain.specular_scale;
  const float cosine = dot(wo, normalize(wo + wi));
  const vec3 film = FilmReflectance(ViewFilm(cosine, 1.4f, 350.0f), vec3(0.9f, 0.6f, 0.2f));
  ExpectNear(lobe / all, film, 1e-4f);
  Material half = gold;
  half.iridescence = 0.25f;
  const Bsdf mixed = Tables().Make(FlatSurface(half, wo), 0.0f);
  const vec3 part = EvaluateBsdf(mixed, wo, wi, kAllLobes).specular / mixed.specular_scale / all;
  const float s = SchlickWeight(cosine);
  const vec3 schlick = vec3(0.9f, 0.6f, 0.2f) * (1 - s) + vec3(s);
  ExpectNear(part, glm::mix(schlick, film, 0.25f), 1e-4f, "mixed");
}

TEST(IridescenceTest, LobeIsReciprocalUpToCompensation) {
  for (const float metallic : {0.0f, 0.4f, 1.0f}) {
    Material material = Filmed(Metal(vec3(0.9f, 0.6f, 0.2f), 0.6f), 1.5f, 300.0f);
    material.metallic = metallic;
    material.base_color = vec4(0, 0, 0, 1);  // no diffuse light
    const vec3 a = Towards(0.3f, 0.1f);
    const vec3 b = Towards(0.8f, 2.0f);
    const Bsdf from_a = Tables().Make(FlatSurface(material, a), 0.0f);
    const Bsdf from_b = Tables().Make(FlatSurface(material, b), 0.0f);
    const vec3 ab = EvaluateBsdf(from_a, a, b, kAllLobes).specular / (b.z * from_a.specular_scale);
    const vec3 ba = EvaluateBsdf(from_b, b, a, kAllLobes).specular / (a.z * from_b.specular_scale);
    ASSERT_GT(MaxComponent(ab), 0.0f);
    ExpectNear(ab / ba, vec3(1.0f), 1e-4f);
  }
}

// Basic radiance, as without a film: the film reflects the same for a ray and its reverse.
TEST(IridescenceTest, GlassIsReciprocal) {
  const Material glass = Filmed(Glass(1.5f, 0.6f), 1.8f, 320.0f);
  const vec3 outside = Towards(0.7f, 0.2f);
  const vec3 inside = -Towards(0.85f, 2.9f + kPi);
  const Bsdf in = Tables().Make(FlatSurface(glass, outside), 0.0f);
  const Bsdf out = Tables().Make(FlatSurface(glass, -inside, false), 0.0f);
  const float forward = EvaluateBsdf(in, outside, inside, kAllLobes).specular.x /
                        (std::abs(inside.z) * in.glass_compensation);
  const float back = EvaluateBsdf(out, -inside, -outside, kAllLobes).specular.x /
                     (std::abs(outside.z) * out.glass_compensation);
  ASSERT_GT(forward, 0.0f);
  EXPECT_NEAR(forward / back, 1.5f * 1.5f, 1e-3f);
}

/// A wall before the camera under a sky.
SceneBuilder WallOf(const Material& material) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(0.7f, 1.0f, 1.3f);
  builder.Add(Quad(vec3(-9, -9, -3), vec3(18, 0, 0), vec3(0, 18, 0)), material);
  builder.CameraTransform().rotation = Rotation(vec3(0, 1, 0), 0.8f);
  return builder;
}

Image3 Picture(const SceneBuilder& builder, int samples = 4) {
  return RenderMean(builder.scene, SmallSettings(8, 8, 1), samples);
}

TEST(IridescenceTest, WithoutWeightOrThicknessEveryBitStays) {
  for (const Material& base : {Metal(vec3(0.9f, 0.6f, 0.2f), 0.3f), Plastic(0.4f),
                               Glass(1.5f, 0.2f), Metal(vec3(0.5f), 0.0f)}) {
    Material none = Filmed(base, 1.8f, 300.0f);
    none.iridescence = 0.0f;
    const Material thin = Filmed(base, 1.8f, 0.0f);
    EXPECT_FALSE(IsLayered(none));
    EXPECT_FALSE(IsLayered(thin));
    const Image3 plain = Picture(WallOf(base));
    for (const Material& material : {none, thin}) {
      const Image3 found = Picture(WallOf(material));
      for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 8; ++x) {
          EXPECT_EQ(Pixel(found, x, y), Pixel(plain, x, y));
        }
      }
    }
  }
}

Texture UniformTexture(uint8_t r, uint8_t g, uint8_t b) {
  Texture texture;
  texture.width = texture.height = 1;
  texture.texels = {r, g, b, 255};
  return texture;
}

TEST(IridescenceTest, TexturesAreWeightAndThickness) {
  Material material = Filmed(Metal(vec3(0.9f, 0.6f, 0.2f), 0.3f), 1.8f, 600.0f);
  material.iridescence = 0.8f;
  material.iridescence_thickness_min = 100.0f;
  SceneBuilder textured = WallOf(material);
  textured.scene.textures = {UniformTexture(51, 255, 0), UniformTexture(255, 102, 0)};
  textured.scene.materials[0].iridescence_texture.texture = 0;
  textured.scene.materials[0].iridescence_thickness_texture.texture = 1;
  SceneBuilder plain = WallOf(material);
  plain.scene.materials[0].iridescence = 0.16f;
  plain.scene.materials[0].iridescence_thickness_max = 300.0f;
  ExpectNear(Mean(Picture(textured)), Mean(Picture(plain)), 1e-5f);
  // Where the texture takes the film away the base remains.
  textured.scene.textures[0] = UniformTexture(0, 255, 255);
  ExpectNear(Mean(Picture(textured, 64)),
             Mean(Picture(WallOf(Metal(vec3(0.9f, 0.6f, 0.2f), 0.3f)), 64)), 1e-4f, "none");
}

// A mirror's colour is the film's, by all ways of finding light; a rough one's is the lobe's mean.
TEST(IridescenceTest, RenderedColourIsTheFilms) {
  const vec3 f0(0.8f, 0.5f, 0.3f);
  SceneBuilder builder = WallOf(Filmed(Metal(f0, 0.0f), 1.5f, 420.0f));
  builder.scene.environment.radiance = vec3(1.0f);
  builder.scene.cameras[0].yfov = 1e-3f;
  const vec3 film = FilmReflectance(ViewFilm(std::cos(0.8f), 1.5f, 420.0f), f0);
  ExpectNear(Mean(Picture(builder)), film, 1e-3f, "mirror");
  builder.scene.materials[0].roughness = 0.5f;
  const vec3 rough = vec3(Furnace(builder.scene.materials[0], std::cos(0.8f)));
  for (const LightSampling sampling :
       {LightSampling::kMis, LightSampling::kLight, LightSampling::kBsdf}) {
    const vec3 seen = Mean(RenderMean(builder.scene, SmallSettings(4, 4, 1), 1024, sampling));
    ExpectNear(seen, rough, 0.01f, std::to_string(static_cast<int>(sampling)));
  }
}

// Shadow rays pass a smooth sheet as scattered rays do.
TEST(IridescenceTest, LightThroughASheetIsTheSameForAllStrategies) {
  Material sheet = Filmed(Glass(1.5f, 0.0f), 1.8f, 350.0f);
  sheet.solid = false;
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 0.5f, 0));
  builder.CameraTransform().rotation = Rotation(vec3(1, 0, 0), -kPi / 2);
  builder.scene.cameras[0].yfov = 1e-2f;
  builder.Add(Quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(-9, 1, 9), vec3(18, 0, 0), vec3(0, 0, -18)), sheet);
  builder.Add(Quad(vec3(-1, 2, -1), vec3(2, 0, 0), vec3(0, 0, 2)), Emitter(vec3(3.0f)));
  const RenderSettings settings = SmallSettings(8, 8, 1);
  const vec3 both = Mean(RenderMean(builder.scene, settings, 256));
  const vec3 light = Mean(RenderMean(builder.scene, settings, 256, LightSampling::kLight));
  const vec3 scatter = Mean(RenderMean(builder.scene, settings, 1024, LightSampling::kBsdf));
  ASSERT_GT(both.x, 0.01f);
  ExpectNear(light / both, vec3(1.0f), 0.015f, "light");
  ExpectNear(scatter / both, vec3(1.0f), 0.015f, "scatter");
}

TEST(IridescenceTest, ValuesOutOfRangeAreRefused) {
  const auto message = [](const Material& material) {
    const auto renderer = Renderer::Create(WallOf(material).scene, SmallSettings(2, 2, 1));
    EXPECT_EQ(renderer.status().code(), StatusCode::kInvalidArgument);
    return renderer.status().message();
  };
  Material material = Filmed(Plastic(0.5f), 0.9f, 100.0f);
  EXPECT_THAT(message(material), HasSubstr("iridescence ior is 0.9, expected at least 1"));
  material = Filmed(Plastic(0.5f), 1.3f, -1.0f);
  EXPECT_THAT(message(material),
              HasSubstr("iridescence thickness maximum is -1, expected 0 to 1e+06"));
  material = Filmed(Plastic(0.5f), 1.3f, 100.0f);
  material.iridescence = 1.5f;
  EXPECT_THAT(message(material), HasSubstr("iridescence is 1.5, expected 0 to 1"));
}

}  // namespace
}  // namespace stillray::render::iridescence_test
