// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The guides of a frame.
#include "render/guides.h"

#include <cmath>
#include <limits>

#include "test_scenes.h"

namespace stillray::render::guides_test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

RenderSettings GuideSettings() {
  return SmallSettings(kWidth, kHeight, 1);
}

// Pixels per unit of tangent for the builder's camera.
float Focal(const Scene& scene) {
  return kHeight * 0.5f / std::tan(0.5f * scene.cameras[0].yfov);
}

TEST(GuidesTest, DepthIsThatOfATiltedPlane) {
  // The plane through (0, 0, -5) with normal n: a ray direction d (with -z = 1) meets it at
  // t = n.c / n.d, and linear depth is t itself.
  SceneBuilder builder;
  const vec3 u = glm::normalize(vec3(1, 0, 0.7f));
  const vec3 v(0, 1, 0);
  builder.Add(Quad(vec3(0, 0, -5) - (u + v) * 20.0f, u * 40.0f, v * 40.0f), Lambert(vec3(0.5f)));
  const Frame frame = RenderOne(builder.scene, GuideSettings());
  const vec3 n = glm::cross(u, v);
  const float f = Focal(builder.scene);
  for (int y = 0; y < kHeight; y += 5) {
    for (int x = 0; x < kWidth; x += 5) {
      const vec3 d((x + 0.5f - kWidth / 2) / f, -(y + 0.5f - kHeight / 2) / f, -1.0f);
      const float expected = glm::dot(n, vec3(0, 0, -5)) / glm::dot(n, d);
      EXPECT_NEAR(frame.guides.depth(x, y) / expected, 1.0f, 1e-5f) << x << ' ' << y;
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(frame.guides.normal[c](x, y), n[c], 1e-5f);
      }
    }
  }
}

TEST(GuidesTest, IdRoughnessAndMissesAreMarked) {
  SceneBuilder builder;
  Material rough = Metal(vec3(0.9f), 0.6f);
  builder.Add(Quad(vec3(-3, -1, -4), vec3(2, 0, 0), vec3(0, 2, 0)), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(0.5f, -1, -4), vec3(2, 0, 0), vec3(0, 2, 0)), rough);
  builder.scene.environment.radiance = vec3(0.25f);
  const Frame frame = RenderOne(builder.scene, GuideSettings());
  EXPECT_EQ(frame.guides.id(5, 24), 1u);
  EXPECT_EQ(frame.guides.id(45, 24), 2u);
  EXPECT_FLOAT_EQ(frame.guides.roughness(45, 24), 0.6f);
  EXPECT_EQ(frame.guides.id(32, 2), 0u);
  EXPECT_EQ(frame.guides.depth(32, 2), std::numeric_limits<float>::infinity());
  EXPECT_EQ(Pixel(frame.guides.normal, 32, 2), vec3(0.0f));
  EXPECT_EQ(Pixel(frame.guides.albedo, 32, 2), vec3(0.0f));
  EXPECT_EQ(Pixel(frame.background, 32, 2), vec3(0.25f));
  EXPECT_EQ(Pixel(frame.background, 5, 24), vec3(0.0f));
  EXPECT_EQ(Pixel(frame.guides.albedo, 5, 24), vec3(0.5f));
  EXPECT_GT(frame.guides.specular_albedo[0](45, 24), 0.8f);
  EXPECT_EQ(frame.guides.albedo[0](45, 24), 0.0f);
}

TEST(GuidesTest, NormalsFaceTheViewerAlsoFromBehind) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(4, -4, -4), vec3(-8, 0, 0), vec3(0, 8, 0)), Lambert(vec3(0.5f)));
  const Frame frame = RenderOne(builder.scene, GuideSettings());
  EXPECT_EQ(frame.guides.normal[2](32, 24), 1.0f);
}

TEST(GuidesTest, NormalMapsTurnTheNormal) {
  SceneBuilder builder;
  Material material = Lambert(vec3(0.5f));
  Texture texture;
  texture.width = texture.height = 1;
  texture.texels = {255, 255, 128, 255};  // (1, 1, 0) almost: clear of the horizon by the scale
  builder.scene.textures.push_back(texture);
  material.normal_texture.texture = 0;
  material.normal_scale = 0.00784314f / 1.0039216f * 0.5f;  // z is 1/255: slope 1/2
  Mesh quad = Quad(vec3(-4, -4, -4), vec3(8, 0, 0), vec3(0, 8, 0));
  // v runs up this quad and down its texture: mirrored.
  quad.tangents.assign(4, vec4(1, 0, 0, -1));
  builder.Add(quad, material);
  const Frame with_tangents = RenderOne(builder.scene, GuideSettings());
  builder.scene.meshes[0].tangents.clear();
  const Frame without = RenderOne(builder.scene, GuideSettings());
  const vec3 expected = Pixel(with_tangents.guides.normal, 32, 24);
  EXPECT_GT(expected.x, 0.3f);
  EXPECT_LT(expected.y, -0.3f);  // green points up in the texture
  EXPECT_NEAR(glm::length(expected), 1.0f, 1e-5f);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(without.guides.normal[c](32, 24), expected[c], 1e-5f) << c;
  }
}

TEST(GuidesTest, JitterMovesAllRaysAlike) {
  SceneBuilder builder;
  const vec3 u = glm::normalize(vec3(1, 0, 0.7f));
  builder.Add(Quad(vec3(0, 0, -5) - (u + vec3(0, 1, 0)) * 20.0f, u * 40.0f, vec3(0, 40, 0)),
              Lambert(vec3(0.5f)));
  RenderSettings settings = GuideSettings();
  settings.jitter = true;
  RenderMoment moment;
  moment.frame_index = 17;
  const Frame frame = RenderOne(builder.scene, settings, moment);
  EXPECT_EQ(frame.index, 17);
  EXPECT_EQ(frame.jitter_x, FrameJitter(1).x);
  EXPECT_EQ(frame.jitter_y, FrameJitter(1).y);
  const float f = Focal(builder.scene);
  EXPECT_FLOAT_EQ(frame.focal_pixels, f);
  const vec3 n = glm::cross(u, vec3(0, 1, 0));
  const vec3 d((10.5f + frame.jitter_x - kWidth / 2) / f,
               -(20.5f + frame.jitter_y - kHeight / 2) / f, -1.0f);
  EXPECT_NEAR(frame.guides.depth(10, 20), glm::dot(n, vec3(0, 0, -5)) / glm::dot(n, d), 1e-4f);
}

void ExpectMotion(const Frame& frame, int x, int y, vec2 expected) {
  EXPECT_NEAR(frame.guides.motion[0](x, y), expected.x, 0.01f) << x << ' ' << y;
  EXPECT_NEAR(frame.guides.motion[1](x, y), expected.y, 0.01f) << x << ' ' << y;
}

SceneBuilder WallAt(float distance) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-20, -20, -distance), vec3(40, 0, 0), vec3(0, 40, 0)), Lambert(vec3(0.5f)));
  return builder;
}

TEST(MotionTest, StillSceneHasNone) {
  SceneBuilder builder = WallAt(4);
  builder.scene.environment.radiance = vec3(1.0f);
  const Frame frame = RenderOne(builder.scene, GuideSettings(), MomentAt(1.0, 0.5));
  ExpectMotion(frame, 3, 40, vec2(0.0f));
}

TEST(MotionTest, CameraMovesSideways) {
  SceneBuilder builder = WallAt(4);
  builder.Move(0, vec3(1, 0.5f, 0));
  const Frame frame = RenderOne(builder.scene, GuideSettings(), MomentAt(0.5, 0.25));
  // Moved by (0.25, 0.125) since then: the point at p was farther right and farther up.
  const float f = Focal(builder.scene);
  for (const int x : {2, 33, 60}) {
    ExpectMotion(frame, x, 11, vec2(0.25f * f / 4, -0.125f * f / 4));
  }
}

TEST(MotionTest, CameraTurns) {
  SceneBuilder builder = WallAt(4);
  AnimationChannel turn;
  turn.node = 0;
  turn.property = AnimatedProperty::kRotation;
  turn.times = {0.0f, 1.0f};
  turn.values = {Rotation(vec3(0, 1, 0), 0.0f), Rotation(vec3(0, 1, 0), 0.1f)};
  builder.scene.animation.push_back(turn);
  builder.scene.environment.radiance = vec3(1.0f);
  const float f = Focal(builder.scene);
  // Also without the wall: the background is at infinity.
  for (const bool wall : {true, false}) {
    if (!wall) {
      builder.scene.instances.clear();
    }
    const Frame frame = RenderOne(builder.scene, GuideSettings(), MomentAt(1.0, 0.0));
    for (const int x : {4, 31, 55}) {
      // Turned left by 0.1: the direction at tangent t was 0.1 further left.
      const float tangent = (x + 0.5f - kWidth / 2) / f;
      const float before = std::tan(std::atan(tangent) - 0.1f);
      EXPECT_NEAR(frame.guides.motion[0](x, 24), (before - tangent) * f, 0.01f) << x;
    }
  }
}

TEST(MotionTest, ObjectMoves) {
  SceneBuilder builder;
  const int wall = builder.Add(Quad(vec3(-20, -20, 0), vec3(40, 0, 0), vec3(0, 40, 0)),
                               Lambert(vec3(0.5f)), At(vec3(0, 0, -4)));
  builder.Move(builder.InstanceNode(wall), vec3(0, -2, -1));
  const Frame frame = RenderOne(builder.scene, GuideSettings(), MomentAt(1.0, 0.5));
  const float f = Focal(builder.scene);
  for (const int x : {5, 50}) {
    const float y_now = -(10.5f - kHeight / 2) / f * 5;  // on the wall, now 5 away
    const float x_now = (x + 0.5f - kWidth / 2) / f * 5;
    const float y_before = (y_now + 1.0f) * f / 4.5f;
    const float x_before = x_now * f / 4.5f;
    ExpectMotion(frame, x, 10, vec2(x_before - x_now * f / 5, -(y_before - y_now * f / 5)));
    EXPECT_NEAR(frame.guides.depth(x, 10), 5.0f, 1e-4f);
  }
}

TEST(MotionTest, PointsBehindThePreviousCameraCameFromOutside) {
  SceneBuilder builder = WallAt(4);
  builder.Move(0, vec3(0, 0, 10));
  const Frame frame = RenderOne(builder.scene, GuideSettings(), MomentAt(0.0, 0.0));
  ExpectMotion(frame, 5, 5, vec2(0.0f));
  builder.scene.animation[0].values[0] = vec4(0, 0, -10, 0);
  builder.scene.animation[0].values[1] = vec4(0, 0, 0, 0);
  const Frame behind = RenderOne(builder.scene, GuideSettings(), MomentAt(1.0, 0.0));
  EXPECT_GT(behind.guides.motion[0](5, 5), kWidth);
  EXPECT_TRUE(std::isfinite(behind.guides.motion[0](5, 5)));
}

TEST(PreviousNormalTest, ScenesThatDoNotTurnHaveNone) {
  SceneBuilder builder = WallAt(4);
  EXPECT_TRUE(RenderOne(builder.scene, GuideSettings()).guides.previous_normal.empty());
  builder.Move(0, vec3(0, 0, 1));  // the camera
  builder.Move(builder.InstanceNode(0), vec3(0.25f, 0, 0));
  EXPECT_TRUE(
      RenderOne(builder.scene, GuideSettings(), MomentAt(1.0, 0.5)).guides.previous_normal.empty());
}

// In double precision: the mesh's normals by the inverse transpose of the instance's matrix.
TEST(PreviousNormalTest, IsThatOfTheInstanceOneFrameAgo) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-9, -9, -9), vec3(18, 0, 0), vec3(0, 18, 0)), Lambert(vec3(0.5f)));
  Transform skewed = At(vec3(0, 0, -5));
  skewed.scale = vec3(-1.5f, 1, 0.6f);  // mirrors, and does not keep angles
  const int pivot = builder.AddNode(skewed);
  const int box = builder.Add(BoxWithoutLids(1), Lambert(vec3(0.5f)));
  builder.scene.nodes[static_cast<size_t>(builder.InstanceNode(box))].parent = pivot;
  builder.Turn(builder.InstanceNode(box), vec3(0, 1, 0), {0.5f, 1.1f});
  const Frame frame = RenderOne(builder.scene, GuideSettings(), MomentAt(0.1, 0.0));
  const auto turned = [](double angle, double side) {  // of the side that faces +z, or another
    const double c = std::cos(angle + side);
    const double s = std::sin(angle + side);
    const glm::dvec3 n(s / -1.5, 0, c / 0.6);
    return n / std::sqrt(glm::dot(n, n));
  };
  int of_box = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const vec3 previous = Pixel(frame.guides.previous_normal, x, y);
      if (frame.guides.id(x, y) != 2) {
        ASSERT_EQ(previous, vec3(0.0f)) << x << ' ' << y;
        continue;
      }
      ++of_box;
      const glm::dvec3 now(Pixel(frame.guides.normal, x, y));
      double nearest = 2;
      glm::dvec3 expected(0.0);
      for (int i = 0; i < 4; ++i) {
        const double side = i * 1.5707963267948966;
        const glm::dvec3 off = turned(1.1f, side) - now;
        if (glm::dot(off, off) < nearest) {
          nearest = glm::dot(off, off);
          expected = turned(0.5f, side);
        }
      }
      ASSERT_LT(nearest, 1e-9) << x << ' ' << y;
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(previous[c], expected[c], 1e-5) << x << ' ' << y;
      }
    }
  }
  EXPECT_GT(of_box, kWidth * kHeight / 10);
}

// Blended sheets in front of a wall, whose light is not separated: guides are mixtures, light of
// the surfaces themselves is exact.
TEST(LayersTest, BlendedLayersMix) {
  SceneBuilder builder;
  Material veil = Lambert(vec3(0.8f));
  veil.alpha_mode = AlphaMode::kBlend;
  veil.base_color.w = 0.25f;
  veil.emission = vec3(4.0f);
  builder.Add(Quad(vec3(-9, -9, -2), vec3(18, 0, 0), vec3(0, 18, 0)), veil);
  builder.scene.environment.radiance = vec3(2.0f);
  RenderSettings settings = GuideSettings();
  settings.virtual_guides = false;
  Frame frame = RenderOne(builder.scene, settings);
  EXPECT_NEAR(frame.background[0](9, 9), 1.5f, 1e-5f);
  EXPECT_NEAR(frame.emission[0](9, 9), 1.0f, 1e-5f);
  EXPECT_NEAR(frame.guides.albedo[0](9, 9), 0.2f, 1e-5f);
  EXPECT_EQ(frame.guides.id(9, 9), 1u);

  builder.Add(Quad(vec3(-9, -9, -6), vec3(18, 0, 0), vec3(0, 18, 0)), Lambert(vec3(0.4f)));
  frame = RenderOne(builder.scene, settings);
  EXPECT_EQ(frame.background[0](9, 9), 0.0f);
  EXPECT_NEAR(frame.guides.albedo[0](9, 9), 0.2f + 0.3f, 1e-5f);
  EXPECT_EQ(frame.guides.id(9, 9), 2u);
  EXPECT_NEAR(frame.guides.depth(9, 9), 6.0f, 1e-4f);
}

TEST(LayersTest, MasksAreHolesOrSolid) {
  SceneBuilder builder;
  Material mask = Lambert(vec3(0.8f));
  mask.alpha_mode = AlphaMode::kMask;
  Texture texture;
  texture.width = 2;
  texture.height = 1;
  texture.nearest = true;
  texture.texels = {255, 255, 255, 100, 255, 255, 255, 200};
  builder.scene.textures.push_back(texture);
  mask.base_color_texture.texture = 0;
  builder.Add(Quad(vec3(-9, -9, -3), vec3(18, 0, 0), vec3(0, 18, 0)), mask);
  builder.Add(Quad(vec3(-9, -9, -6), vec3(18, 0, 0), vec3(0, 18, 0)), Lambert(vec3(0.4f)));
  const Frame frame = RenderOne(builder.scene, GuideSettings());
  EXPECT_EQ(frame.guides.id(10, 20), 2u);
  EXPECT_EQ(frame.guides.id(50, 20), 1u);
  EXPECT_NEAR(frame.guides.albedo[0](10, 20), 0.4f, 1e-5f);
}

}  // namespace
}  // namespace stillray::render::guides_test
