// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The thin lens against formulas of its own: circles of confusion, areas of apertures, light that
// is kept, and guides of what the samples see.
#include "render/lens.h"

#include <cmath>
#include <cstring>

#include "core/colour.h"
#include "render/moment.h"
#include "render/test_scenes.h"

namespace stillray::render::lens_test {
namespace {

using ::testing::HasSubstr;

constexpr double kTurn = 6.283185307179586;

vec2 Even(int i, int n) {
  const float side = std::sqrt(static_cast<float>(n));
  return {(static_cast<float>(i % static_cast<int>(side)) + 0.5f) / side,
          (static_cast<float>(i / static_cast<int>(side)) + 0.5f) / side};
}

/// A picture of one row of pixels a side, each of a grey.
Texture Mask(int width, int height, const std::vector<uint8_t>& greys) {
  Texture mask;
  mask.width = width;
  mask.height = height;
  for (const uint8_t grey : greys) {
    mask.texels.insert(mask.texels.end(), {grey, grey, grey, 255});
  }
  return mask;
}

struct Moments {
  glm::dvec2 mean = glm::dvec2(0.0);
  double square = 0;  ///< mean of x^2 + y^2
};

Moments MomentsOf(const LensArrays& lens) {
  constexpr int kPoints = 1 << 16;
  Moments moments;
  for (int i = 0; i < kPoints; ++i) {
    const glm::dvec2 p(LensPoint(lens, Even(i, kPoints)));
    moments.mean += p / double{kPoints};
    moments.square += glm::dot(p, p) / kPoints;
  }
  return moments;
}

TEST(LensTest, PointsFillThePolygonEvenly) {
  for (const int blades : {0, 3, 5, 6, 8, 32}) {
    for (const float turns : {0.0f, 0.03f, 0.9f}) {
      SCOPED_TRACE(blades);
      LensArrays lens{};
      lens.blades = blades;
      lens.rotation = turns;
      const Moments found = MomentsOf(lens);
      EXPECT_NEAR(found.mean.x, 0, 2e-4);
      EXPECT_NEAR(found.mean.y, 0, 2e-4);
      // The polar moment of a regular polygon over its area: R^2 (2 + cos(2 pi / n)) / 6, which
      // tends to R^2 / 2.
      const double expected = blades == 0 ? 0.5 : (2 + std::cos(kTurn / blades)) / 6;
      EXPECT_NEAR(found.square, expected, 2e-4);
    }
  }
}

TEST(LensTest, PointsStayWithinThePolygonAndReachItsArea) {
  constexpr int kPoints = 1 << 16;
  constexpr int kGrid = 64;
  const int blades = 5;
  LensArrays lens{};
  lens.blades = blades;
  lens.rotation = 0.1f;
  std::vector<int> cells(kGrid * kGrid, 0);
  for (int i = 0; i < kPoints; ++i) {
    const glm::dvec2 p(LensPoint(lens, Even(i, kPoints)));
    for (int k = 0; k < blades; ++k) {
      const double middle = kTurn * (0.1 + (k + 0.5) / blades);
      EXPECT_LE(p.x * std::cos(middle) + p.y * std::sin(middle),
                std::cos(kTurn / 2 / blades) + 1e-6);
    }
    const int x = static_cast<int>((p.x + 1) / 2 * kGrid);
    const int y = static_cast<int>((p.y + 1) / 2 * kGrid);
    ++cells[static_cast<size_t>(y * kGrid + x)];
  }
  // The area from the density of points in the middle, where all cells are full.
  double inner = 0;
  for (int y = kGrid / 2 - 8; y < kGrid / 2 + 8; ++y) {
    for (int x = kGrid / 2 - 8; x < kGrid / 2 + 8; ++x) {
      inner += cells[static_cast<size_t>(y * kGrid + x)];
    }
  }
  const double density = inner / (16 * 16 * (2.0 / kGrid) * (2.0 / kGrid));
  const double area = 0.5 * blades * std::sin(kTurn / blades);
  EXPECT_NEAR(kPoints / density, area, 0.02 * area);
}

TEST(LensTest, MaskIsSampledByBrightness) {
  SceneBuilder builder;
  // The longer side fills the square; brightness is linear: 188 is half of 255.
  builder.scene.textures = {Mask(4, 2, {0, 255, 0, 0, 0, 0, 188, 0})};
  builder.scene.cameras[0].lens.mask = 0;
  const LensMasks masks(builder.scene);
  const LensArrays lens = MakeLensArrays(builder.scene.cameras[0].lens, masks);
  int upper = 0;
  constexpr int kPoints = 1 << 14;
  for (int i = 0; i < kPoints; ++i) {
    const vec2 p = LensPoint(lens, Even(i, kPoints));
    if (p.y > 0) {
      ++upper;
      EXPECT_TRUE(p.x >= -0.5f && p.x <= 0.0f && p.y <= 0.5f) << p.x << " " << p.y;
    } else {
      EXPECT_TRUE(p.x >= 0.0f && p.x <= 0.5f && p.y >= -0.5f) << p.x << " " << p.y;
    }
  }
  const double ratio = SrgbDecode(188.0f / 255.0f);
  EXPECT_NEAR(static_cast<double>(upper) / kPoints, 1 / (1 + ratio), 0.01);
}

constexpr int kSize = 65;
constexpr float kYfov = 0.8f;

/// A small emitter on the axis, facing the camera.
Scene Emitter(float z, float half_side) {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = kYfov;
  const float s = half_side;
  builder.Add(Quad(vec3(-s, -s, -z), vec3(2 * s, 0, 0), vec3(0, 2 * s, 0)),
              render::Emitter(vec3(100.0f)));
  return builder.scene;
}

struct Spot {
  double light = 0;
  double square = 0;  ///< mean squared distance from the centre, pixels
};

Spot SpotOf(const Image3& image) {
  Spot spot;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double light = image[1](x, y);
      const double dx = x + 0.5 - 0.5 * image.width();
      const double dy = y + 0.5 - 0.5 * image.height();
      spot.light += light;
      spot.square += light * (dx * dx + dy * dy);
    }
  }
  spot.square /= spot.light;
  return spot;
}

// A point at depth z is seen from lens point l at l (1 / zf - 1 / z) from the centre, in tangents:
// the circle of confusion has the radius R |1 / zf - 1 / z|. Its second moment is that of the
// aperture; a square of side 2 s adds 2 s^2 / 3, a pixel 1 / 6.
TEST(LensTest, CircleOfConfusionIsThatOfTheFormula) {
  const double pixels = kSize / 2.0 / std::tan(0.5 * kYfov);  // per tangent
  for (const int blades : {0, 3, 6}) {
    for (const float z : {2.0f, 3.0f, 12.0f}) {
      SCOPED_TRACE(testing::Message() << blades << " blades, depth " << z);
      const float half_side = 0.02f * z;
      const Scene scene = Emitter(z, half_side);
      RenderSettings settings = SmallSettings(kSize, kSize, 1);
      settings.jitter = true;
      settings.aperture = 0.5f;
      settings.focus = 4.0f;
      settings.blades = blades;
      const Spot spot = SpotOf(RenderMean(scene, settings, 256));
      const Spot sharp = [&] {
        settings.aperture = 0.0f;
        return SpotOf(RenderMean(scene, settings, 256));
      }();
      const double radius = 0.5 * std::abs(1.0 / 4.0 - 1.0 / z) * pixels;
      const double shape = blades == 0 ? 0.5 : (2 + std::cos(kTurn / blades)) / 6;
      const double side = half_side / z * pixels;
      const double own = 2 * side * side / 3 + 1.0 / 6;
      EXPECT_NEAR(sharp.square, own, 0.3);  // its edges are rounded to pixels
      EXPECT_NEAR(spot.square, shape * radius * radius + own,
                  0.03 * (shape * radius * radius + own));
      EXPECT_NEAR(spot.light, sharp.light, 0.02 * sharp.light);
    }
  }
}

TEST(LensTest, PlaneOfFocusIsAsSharpAsThroughAPinhole) {
  const Scene scene = Emitter(4.0f, 0.5f);
  RenderSettings settings = SmallSettings(kSize, kSize, 1);
  const Image3 sharp = RenderMean(scene, settings, 4);
  settings.aperture = 0.5f;
  settings.focus = 4.0f;
  const Image3 lens = RenderMean(scene, settings, 4);
  settings.focus = 0.0f;  // the emitter is in the centre
  const Image3 by_itself = RenderMean(scene, settings, 4);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      EXPECT_NEAR(lens[0](x, y), sharp[0](x, y), 1e-3f) << x << " " << y;
      EXPECT_NEAR(by_itself[0](x, y), sharp[0](x, y), 1e-3f) << x << " " << y;
    }
  }
}

TEST(LensTest, LightIsKept) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(1.0f);
  RenderSettings settings = SmallSettings(16, 16, 1);
  settings.aperture = 2.0f;
  settings.focus = 3.0f;
  const Image3 sky = RenderMean(builder.scene, settings, 4);
  EXPECT_NEAR(Mean(sky).x, 1.0f, 1e-6f);
  // A white furnace: a white box around the camera that shines would do; a white convex body in a
  // sky of 1 is as bright as the sky.
  builder.Add(FacetedSphere(vec3(0, 0, -5), 1.5f, 2), Lambert(vec3(1.0f)));
  const Image3 furnace = RenderMean(builder.scene, settings, 64);
  EXPECT_NEAR(Mean(furnace).x, 1.0f, 0.005f);
}

TEST(LensTest, FNumberIsThatOfAFullFrameCamera) {
  Camera camera;
  camera.yfov = kYfov;
  const CameraView wide = MakeCameraView(camera, mat4(1.0f), 300, 200);
  Lens lens;
  lens.f_number = 2.8f;
  // 36 mm across the wider side.
  const double focal_length = 0.018 / (1.5 * std::tan(0.5 * kYfov));
  EXPECT_NEAR(LensRadius(lens, wide), focal_length / 2.8 / 2, 1e-8);
  const CameraView tall = MakeCameraView(camera, mat4(1.0f), 200, 300);
  EXPECT_NEAR(LensRadius(lens, tall), 0.018 / std::tan(0.5 * kYfov) / 2.8 / 2, 1e-8);
  lens.f_number = 0.0f;
  lens.radius = 0.25f;
  EXPECT_EQ(LensRadius(lens, wide), 0.25f);
}

/// Two textured planes, the nearer one in front of the left half, and a lamp.
SceneBuilder TwoPlanes() {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = kYfov;
  builder.scene.environment.radiance = vec3(0.7f);
  Texture checks;
  checks.width = checks.height = 16;
  for (int i = 0; i < 256; ++i) {
    const uint8_t grey = (i + i / 16) % 2 == 0 ? 230 : 40;
    checks.texels.insert(checks.texels.end(), {grey, grey, grey, 255});
  }
  checks.nearest = true;
  builder.scene.textures.push_back(checks);
  Material textured = Lambert(vec3(1.0f));
  textured.base_color_texture.texture = 0;
  builder.Add(Quad(vec3(-6, -6, -8), vec3(12, 0, 0), vec3(0, 12, 0)), textured);
  builder.Add(Quad(vec3(-3, -3, -3), vec3(3, 0, 0), vec3(0, 6, 0)), textured);
  return builder;
}

bool SameBits(const Image1& a, const Image1& b) {
  for (int y = 0; y < a.height(); ++y) {
    if (std::memcmp(a.Row(y), b.Row(y), sizeof(float) * static_cast<size_t>(a.width())) != 0) {
      return false;
    }
  }
  return a.width() == b.width() && a.height() == b.height();
}

bool SameBits(const Frame& a, const Frame& b) {
  bool same = SameBits(a.guides.depth, b.guides.depth);
  for (int c = 0; c < 3; ++c) {
    same = same && SameBits(a.guides.albedo[c], b.guides.albedo[c]);
    for (size_t k = 0; k < a.signals.size(); ++k) {
      same = same && SameBits(a.signals[k].radiance[c], b.signals[k].radiance[c]);
    }
  }
  return same;
}

RenderSettings Wide(int spp) {
  RenderSettings settings = SmallSettings(48, 32, spp);
  settings.aperture = 0.2f;
  settings.focus = 8.0f;
  return settings;
}

TEST(LensTest, FramesAreDeterministicWithAllSamplers) {
  const SceneBuilder builder = TwoPlanes();
  for (const SamplerKind sampler :
       {SamplerKind::kSobol, SamplerKind::kHalton16, SamplerKind::kZSobol}) {
    RenderSettings settings = Wide(3);
    settings.sampler = sampler;
    const Frame frame = RenderOne(builder.scene, settings);
    EXPECT_TRUE(SameBits(frame, RenderOne(builder.scene, settings)));
    settings.aperture = 0.0f;
    EXPECT_FALSE(SameBits(frame, RenderOne(builder.scene, settings)));
  }
}

TEST(LensTest, NoApertureIsAPinholeToTheBit) {
  SceneBuilder builder = TwoPlanes();
  RenderSettings settings = SmallSettings(48, 32, 2);
  const Frame pinhole = RenderOne(builder.scene, settings);
  settings.aperture = 0.0f;
  settings.focus = 3.0f;
  settings.blades = 6;
  EXPECT_TRUE(SameBits(pinhole, RenderOne(builder.scene, settings)));
}

TEST(LensTest, SettingsReplaceTheLensOfTheScene) {
  SceneBuilder builder = TwoPlanes();
  const RenderSettings settings = Wide(1);
  const Frame wide = RenderOne(builder.scene, settings);
  builder.scene.cameras[0].lens.radius = 0.2f;
  builder.scene.cameras[0].lens.focus = 8.0f;
  EXPECT_TRUE(SameBits(wide, RenderOne(builder.scene, SmallSettings(48, 32, 1))));
  builder.scene.cameras[0].lens.radius = 0.7f;
  EXPECT_TRUE(SameBits(wide, RenderOne(builder.scene, settings)));
}

// The light of a surface lit evenly is proportional to its albedo: divided by the guide, which is
// the mean of the same samples, nothing of the texture remains, sharp or blurred.
TEST(LensTest, AlbedoIsThatOfTheSamplesOwnHits) {
  SceneBuilder builder = TwoPlanes();
  builder.scene.instances.pop_back();  // which casts a shadow
  for (const int spp : {1, 7}) {
    RenderSettings settings = Wide(spp);
    settings.focus = 3.0f;  // the far plane is blurred
    settings.bounces = 1;
    const Frame frame = RenderOne(builder.scene, settings);
    const Image3& light = frame.Find(SignalKind::kDirectDiffuse)->radiance;
    double low = 1e30;
    double high = 0;
    for (int y = 8; y < 24; ++y) {
      for (int x = 34; x < 44; ++x) {
        ASSERT_GT(frame.guides.albedo[0](x, y), 0.0f);
        const double irradiance = light[0](x, y) / frame.guides.albedo[0](x, y);
        low = std::min(low, irradiance);
        high = std::max(high, irradiance);
        EXPECT_NEAR(frame.guides.depth(x, y), 8.0f, 1e-4f);
      }
    }
    EXPECT_LT(high - low, 1e-4 * high) << spp;
  }
  // Many samples: the guide is blurred as the picture is.
  RenderSettings settings = Wide(256);
  settings.focus = 3.0f;
  const Frame blurred = RenderOne(builder.scene, settings);
  settings.aperture = 0.0f;
  const Frame sharp = RenderOne(builder.scene, settings);
  const auto spread = [](const Frame& frame) {
    double sum = 0;
    double square = 0;
    for (int x = 34; x < 44; ++x) {
      sum += frame.guides.albedo[0](x, 16) / 10;
      square += frame.guides.albedo[0](x, 16) * frame.guides.albedo[0](x, 16) / 10;
    }
    return square - sum * sum;
  };
  EXPECT_LT(spread(blurred), 0.2 * spread(sharp));
}

TEST(LensTest, MeansOfFramesAreTheReference) {
  const SceneBuilder builder = TwoPlanes();
  RenderSettings settings = Wide(1024);
  settings.focus = 3.0f;
  const Image3 frame = SumOfLight(RenderOne(builder.scene, settings));
  const Image3 reference = RenderMean(builder.scene, settings, 1024);
  double square = 0;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 48; ++x) {
      square += std::pow(frame[1](x, y) - reference[1](x, y), 2) / (32 * 48);
    }
  }
  EXPECT_LT(std::sqrt(square), 0.02);
  EXPECT_NEAR(Mean(frame).x, Mean(reference).x, 0.003f);
}

TEST(LensTest, GeometryIsThatOfTheSurfaceSeenMost) {
  const SceneBuilder builder = TwoPlanes();
  RenderSettings settings = Wide(64);
  const Frame frame = RenderOne(builder.scene, settings);
  int near = 0;
  int far = 0;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      const float depth = frame.guides.depth(x, y);
      const bool is_near = std::abs(depth - 3.0f) < 1e-3f;
      EXPECT_TRUE(is_near || std::abs(depth - 8.0f) < 1e-3f) << x << " " << y << " " << depth;
      EXPECT_EQ(frame.guides.id(x, y), is_near ? 2u : 1u);
      EXPECT_NEAR(frame.guides.normal[2](x, y), 1.0f, 1e-5f);
      (is_near ? near : far) += 1;
    }
  }
  EXPECT_GT(near, 100);
  EXPECT_GT(far, 100);
}

TEST(LensTest, StaticSceneHasNoMotionInAndOutOfFocus) {
  const SceneBuilder builder = TwoPlanes();
  for (const int spp : {1, 5}) {
    const Frame frame = RenderOne(builder.scene, Wide(spp));
    for (int y = 0; y < frame.height; ++y) {
      for (int x = 0; x < frame.width; ++x) {
        EXPECT_EQ(frame.guides.motion[0](x, y), 0.0f);
        EXPECT_EQ(frame.guides.motion[1](x, y), 0.0f);
      }
    }
  }
}

// The same point of the lens sees the point at p + motion: for a camera that slides sideways by d
// that is d / z in tangents for all points of the lens.
TEST(LensTest, MotionOfASlidingCameraIsThatOfThePinhole) {
  SceneBuilder builder = TwoPlanes();
  builder.Move(0, vec3(0.5f, 0, 0));
  RenderMoment moment;
  moment.seconds = 0.2;
  moment.previous_seconds = 0.1;
  const Frame frame = RenderOne(builder.scene, Wide(1), moment);
  const double pixels = 32 / 2.0 / std::tan(0.5 * kYfov);
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      EXPECT_NEAR(frame.guides.motion[0](x, y), 0.05 / frame.guides.depth(x, y) * pixels, 1e-3);
      EXPECT_NEAR(frame.guides.motion[1](x, y), 0, 1e-3);
    }
  }
}

TEST(LensTest, MirrorsHaveNoVirtualGuidesThroughALens) {
  SceneBuilder builder = TwoPlanes();
  builder.Add(Quad(vec3(0, -1, -5), vec3(2, 0, 0), vec3(0, 2, 0)), Metal(vec3(0.9f), 0.0f));
  RenderSettings settings = Wide(1);
  EXPECT_TRUE(RenderOne(builder.scene, settings).reflection.empty());
  settings.aperture = 0.0f;
  EXPECT_FALSE(RenderOne(builder.scene, settings).reflection.empty());
}

TEST(LensTest, FocusFollowsWhatIsInTheCentre) {
  SceneBuilder builder;
  const int near =
      builder.Add(Quad(vec3(-1, -1, -3), vec3(2, 0, 0), vec3(0, 2, 0)), Lambert(vec3(0.5f)));
  Material pane = Lambert(vec3(0.5f));
  pane.alpha_mode = AlphaMode::kBlend;
  pane.base_color.w = 0.25f;
  builder.Add(Quad(vec3(-1, -1, -1), vec3(2, 0, 0), vec3(0, 2, 0)), pane);
  builder.Move(builder.InstanceNode(near), vec3(0, 0, -2));
  SceneState state(builder.scene);
  state.Update(0.5, 0.25);
  const CameraView view = CamerasOf(state, {}, 8, 8).now;
  EXPECT_NEAR(FindFocus(state, view, false), 4.0f, 1e-5f);
  EXPECT_NEAR(FindFocus(state, view, true), 3.5f, 1e-5f);
  EXPECT_EQ(FindFocus(SceneState(SceneBuilder().scene), view, false), kInfinity);
}

TEST(LensTest, WrongLensesAreNamed) {
  const auto message = [](auto change) {
    SceneBuilder builder;
    change(&builder.scene.cameras[0].lens, &builder.scene);
    const auto renderer = Renderer::Create(builder.scene, SmallSettings(8, 8, 1));
    EXPECT_EQ(renderer.status().code(), StatusCode::kInvalidArgument);
    return renderer.status().message();
  };
  const float nan = std::nanf("");
  EXPECT_THAT(message([](Lens* l, Scene*) { l->radius = -1; }),
              HasSubstr("radius of its lens is -1"));
  EXPECT_THAT(message([&](Lens* l, Scene*) { l->radius = nan; }), HasSubstr("is nan"));
  EXPECT_THAT(message([](Lens* l, Scene*) { l->f_number = -2; }),
              HasSubstr("f-number of its lens is -2"));
  EXPECT_THAT(message([](Lens* l, Scene*) { l->focus = -3; }),
              HasSubstr("focus of its lens is -3"));
  EXPECT_THAT(message([&](Lens* l, Scene*) { l->focus = nan; }), HasSubstr("is nan"));
  EXPECT_THAT(message([](Lens* l, Scene*) { l->blades = 2; }),
              HasSubstr("blades of its lens is 2"));
  EXPECT_THAT(message([&](Lens* l, Scene*) { l->rotation = nan; }), HasSubstr("is nan"));
  EXPECT_THAT(message([](Lens* l, Scene*) { l->mask = 0; }), HasSubstr("there are 0"));
  EXPECT_THAT(message([](Lens* l, Scene* s) {
                s->textures = {Mask(2, 1, {0, 0})};
                l->mask = 0;
              }),
              HasSubstr("is black"));
}

}  // namespace
}  // namespace stillray::render::lens_test
