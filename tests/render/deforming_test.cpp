// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of scenes whose meshes deform.
#include "render/deforming_scene.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include "render/lens.h"

namespace stillray::render::deforming_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 64;
constexpr int kHeight = 48;

RenderMoment MomentAt(double seconds, double previous) {
  RenderMoment moment;
  moment.seconds = seconds;
  moment.previous_seconds = previous;
  moment.frame_index = 2;
  return moment;
}

/// Pixels per unit at distance 1.
double Focal(const Scene& scene) {
  return 0.5 * kHeight / std::tan(0.5 * static_cast<double>(scene.cameras[0].yfov));
}

/// Where a pixel's centre sees the plane z = -distance.
glm::dvec2 Seen(const Scene& scene, int x, int y, double distance) {
  const double scale = distance / Focal(scene);
  return {(x + 0.5 - kWidth / 2) * scale, -(y + 0.5 - kHeight / 2) * scale};
}

glm::dvec2 Projected(const Scene& scene, glm::dvec3 p) {
  return {p.x / -p.z * Focal(scene), -p.y / -p.z * Focal(scene)};
}

void ExpectMotion(const Frame& frame, int x, int y, glm::dvec2 expected) {
  ASSERT_NEAR(static_cast<double>(frame.guides.motion[0](x, y)), expected.x, 0.02) << x << ' ' << y;
  ASSERT_NEAR(static_cast<double>(frame.guides.motion[1](x, y)), expected.y, 0.02) << x << ' ' << y;
}

template <typename Body>
void ForPixels(const Body& body) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      body(x, y);
    }
  }
}

bool SameBits(const Plane<float>& a, const Plane<float>& b) {
  for (int y = 0; y < a.height(); ++y) {
    if (!std::equal(a.Row(y), a.Row(y) + a.width(), b.Row(y))) {
      return false;
    }
  }
  return a.width() == b.width() && a.height() == b.height();
}

bool SameBits(const Image3& a, const Image3& b) {
  return SameBits(a[0], b[0]) && SameBits(a[1], b[1]) && SameBits(a[2], b[2]);
}

bool SameLight(const Frame& a, const Frame& b) {
  bool same = SameBits(a.guides.depth, b.guides.depth) &&
              SameBits(a.guides.normal, b.guides.normal) && SameBits(a.emission, b.emission);
  for (size_t i = 0; i < a.signals.size(); ++i) {
    same = same && SameBits(a.signals[i].radiance, b.signals[i].radiance);
  }
  return same;
}

// A sheet at z = -4 whose target stretches it: x' = (1 + w) x, y' = y + w x.
TEST(DeformingMotionTest, OfAMorphTarget) {
  SceneBuilder builder;
  Mesh sheet = Quad(vec3(-20, -20, 0), vec3(40, 0, 0), vec3(0, 40, 0));
  AddTarget(&sheet, [](vec3 p) { return vec3(p.x, p.x, 0); });
  const int instance = builder.Add(sheet, Lambert(vec3(0.5f)), At(vec3(0, 0, -4)));
  AnimateWeights(&builder, builder.InstanceNode(instance), {0.1f}, {0.9f});
  const Frame frame =
      RenderOne(builder.scene, SmallSettings(kWidth, kHeight, 1), MomentAt(0.5, 0.25));
  const double now = 0.5;
  const double before = 0.3;
  ForPixels([&](int x, int y) {
    const glm::dvec2 p = Seen(builder.scene, x, y, 4);
    const double rest = p.x / (1 + now);
    const glm::dvec3 was(rest * (1 + before), p.y - rest * (now - before), -4);
    ExpectMotion(frame, x, y,
                 Projected(builder.scene, was) - Projected(builder.scene, {p.x, p.y, -4}));
    EXPECT_NEAR(frame.guides.depth(x, y), 4.0f, 1e-4f);
    EXPECT_EQ(Pixel(frame.guides.previous_normal, x, y).z, 1.0f);
  });
}

// A sheet whose right end is moved by joint 1: p' = p + w(x) d, where w grows linearly over it. The
// transform of its node is of no effect.
TEST(DeformingMotionTest, OfASkin) {
  SceneBuilder builder;
  Mesh sheet = Quad(vec3(-10, -10, -4), vec3(20, 0, 0), vec3(0, 20, 0));
  sheet.influences = 4;
  sheet.joints = {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0};
  sheet.weights = {1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0};
  const int instance = builder.Add(sheet, Lambert(vec3(0.5f)), At(vec3(100, 0, 0)));
  const int joint = AddSkin(&builder, instance, {});
  builder.Move(builder.InstanceNode(instance), vec3(0, 9, 0));
  builder.Move(joint, vec3(3, 2, -4));
  const Frame frame =
      RenderOne(builder.scene, SmallSettings(kWidth, kHeight, 1), MomentAt(0.5, 0.25));
  ForPixels([&](int x, int y) {
    // On the plane through p + w(x) d at 0.5 s: solves for the rest position (u, v).
    const glm::dvec2 slope = Seen(builder.scene, x, y, 1);
    const glm::dvec3 d(1.5, 1, -2);
    const auto weight = [](double u) { return (u + 10) / 20; };
    // u + w d.x = slope.x (4 - w d.z), which is linear in u.
    const double left = 1 + d.x / 20 + slope.x * d.z / 20;
    const double u = (slope.x * (4 - d.z / 2) - d.x / 2) / left;
    const double depth = 4 - weight(u) * d.z;
    const double v = slope.y * depth - weight(u) * d.y;
    const glm::dvec3 rest(u, v, -4);
    const glm::dvec3 is = rest + d * weight(u);
    const glm::dvec3 was = rest + d * weight(u) * 0.5;
    ASSERT_NEAR(static_cast<double>(frame.guides.depth(x, y)), depth, 1e-3);
    ExpectMotion(frame, x, y, Projected(builder.scene, was) - Projected(builder.scene, is));
  });
}

// Bound to one joint, a mesh moves like an instance whose node turns.
TEST(DeformingMotionTest, OfARigidSkinIsThatOfItsJoint) {
  const auto make = [](bool skinned) {
    SceneBuilder builder;
    Mesh box = BoxWithoutLids(1);
    if (skinned) {
      box.influences = 4;
      box.joints.assign(4 * box.positions.size(), 0);
      for (size_t i = 0; i < box.positions.size(); ++i) {
        box.weights.insert(box.weights.end(), {1, 0, 0, 0});
      }
    }
    const int instance = builder.Add(box, Lambert(vec3(0.5f)), At(vec3(0.3f, 0, -5)));
    int node = builder.InstanceNode(instance);
    if (skinned) {
      AddSkin(&builder, instance, At(vec3(0.3f, 0, -5)));
      node = builder.scene.skins[0].joints[0];
    }
    builder.Turn(node, glm::normalize(vec3(0.3f, 1, 0.2f)), {0.5f, 1.1f});
    return builder.scene;
  };
  const RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  const Frame skin = RenderOne(make(true), settings, MomentAt(0.1, 0.0));
  const Frame node = RenderOne(make(false), settings, MomentAt(0.1, 0.0));
  int seen = 0;
  ForPixels([&](int x, int y) {
    ASSERT_EQ(skin.guides.id(x, y), node.guides.id(x, y));
    if (node.guides.id(x, y) == 0) {
      return;
    }
    ++seen;
    for (int c = 0; c < 2; ++c) {
      ASSERT_NEAR(skin.guides.motion[c](x, y), node.guides.motion[c](x, y), 1e-3f);
    }
    ExpectNear(Pixel(skin.guides.normal, x, y), Pixel(node.guides.normal, x, y), 1e-5f);
    ExpectNear(Pixel(skin.guides.previous_normal, x, y), Pixel(node.guides.previous_normal, x, y),
               1e-5f);
  });
  EXPECT_GT(seen, 300);
}

// What a mirror shows of such a mesh, and what such a mesh shows as a mirror.
TEST(DeformingMotionTest, OfMirrorImagesIsThatOfTheJoint) {
  const auto make = [](bool skinned, bool as_mirror) {
    SceneBuilder builder;
    const Material mirror = Metal(vec3(0.9f), 0.0f);
    const Material matte = Lambert(vec3(0.5f));
    Mesh sheet = Quad(vec3(-3, -1, -5), vec3(6, 0, 0), vec3(0, 2, 0));
    if (skinned) {
      sheet.influences = 4;
      sheet.joints.assign(16, 0);
      sheet.weights = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    }
    const int instance = builder.Add(sheet, as_mirror ? mirror : matte);
    builder.Add(Quad(vec3(-9, -1.2f, 0), vec3(18, 0, 0), vec3(0, 0, -18)),
                as_mirror ? matte : mirror);
    int node = builder.InstanceNode(instance);
    if (skinned) {
      AddSkin(&builder, instance, {});
      node = builder.scene.skins[0].joints[0];
    }
    builder.Turn(node, vec3(0, 1, 0), {0.0f, 0.1f});
    builder.scene.environment.radiance = vec3(1.0f);
    return builder.scene;
  };
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.virtual_guides = true;
  for (const bool as_mirror : {false, true}) {
    const Frame skin = RenderOne(make(true, as_mirror), settings, MomentAt(0.1, 0.0));
    const Frame node = RenderOne(make(false, as_mirror), settings, MomentAt(0.1, 0.0));
    ASSERT_FALSE(node.reflection.empty());
    int shown = 0;
    ForPixels([&](int x, int y) {
      ASSERT_EQ(skin.reflection.id(x, y), node.reflection.id(x, y));
      shown += node.reflection.id(x, y) != 0 ? 1 : 0;
      for (int c = 0; c < 2; ++c) {
        ASSERT_NEAR(skin.reflection.motion[c](x, y), node.reflection.motion[c](x, y), 5e-3f)
            << as_mirror << ' ' << x << ' ' << y;
      }
    });
    EXPECT_GT(shown, 100) << as_mirror;
  }
}

TEST(DeformingMotionTest, StandsWhileThePoseDoes) {
  const Scene scene = DeformingScene(10);
  const RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  const Frame frame = RenderOne(scene, settings, MomentAt(7.0, 6.0));  // after the last keys
  ForPixels([&](int x, int y) {
    ASSERT_EQ(frame.guides.motion[0](x, y), 0.0f);
    ASSERT_EQ(frame.guides.motion[1](x, y), 0.0f);
    ASSERT_EQ(Pixel(frame.guides.previous_normal, x, y), vec3(0.0f));
  });
}

// The normal of the last frame is the one that this frame's point had then, seen from there.
TEST(DeformingNormalTest, ThePreviousOneIsThatOfThePreviousFrame) {
  SceneBuilder builder;
  Material rough = Lambert(vec3(0.5f));
  const int instance = builder.Add(Tube(40, 64, 0.4f), rough);
  const int elbow = AddSkin(&builder, instance, At(vec3(-1, 0, -5)));
  builder.Turn(elbow, vec3(0, 0, 1), {0.1f, 0.4f});
  RenderSettings settings = SmallSettings(4 * kWidth, 4 * kHeight, 1);
  auto renderer = CreateRenderer(builder.scene, settings);
  ASSERT_TRUE(renderer.ok());
  Frame before;
  Frame now;
  ASSERT_TRUE((*renderer)->RenderFrame(MomentAt(0.0, 0.0), &before).ok());
  ASSERT_TRUE((*renderer)->RenderFrame(MomentAt(0.1, 0.0), &now).ok());
  int compared = 0;
  for (int y = 0; y < settings.height; ++y) {
    for (int x = 0; x < settings.width; ++x) {
      const int u = x + static_cast<int>(std::lround(now.guides.motion[0](x, y)));
      const int v = y + static_cast<int>(std::lround(now.guides.motion[1](x, y)));
      const vec3 n = Pixel(now.guides.normal, x, y);
      if (now.guides.id(x, y) == 0 || u < 0 || v < 0 || u >= settings.width ||
          v >= settings.height || before.guides.id(u, v) == 0 || n.z < 0.5f) {
        continue;
      }
      ++compared;
      // Half a pixel of the tube is an angle of up to 0.03.
      ExpectNear(Pixel(now.guides.previous_normal, x, y), Pixel(before.guides.normal, u, v), 0.06f,
                 "previous normal");
    }
  }
  EXPECT_GT(compared, 2000);
}

// Normals of a tube that a mean of two joints' matrices shears, against the differences of the
// points that neighbouring pixels see.
TEST(DeformingNormalTest, IsPerpendicularToWhatIsSeen) {
  SceneBuilder builder;
  Mesh tube = Tube(60, 256, 0.5f);
  for (size_t i = 0; i < tube.weights.size(); i += 4) {
    tube.weights[i] = 0.4f;
    tube.weights[i + 1] = 0.6f;
  }
  const int instance = builder.Add(tube, Lambert(vec3(0.5f)));
  const int elbow = AddSkin(&builder, instance, At(vec3(-1, 0, -4)));
  builder.scene.nodes[static_cast<size_t>(elbow)].local.scale = vec3(1.5f, 0.6f, 0.4f);
  builder.Turn(elbow, vec3(0, 0, 1), {0.0f, 0.8f});
  RenderSettings settings = SmallSettings(4 * kWidth, 4 * kHeight, 1);
  const Frame frame = RenderOne(builder.scene, settings, MomentAt(0.1, 0.05));
  const double focal = 4 * Focal(builder.scene);
  const auto point = [&](int x, int y) {
    const auto depth = static_cast<double>(frame.guides.depth(x, y));
    return glm::dvec3((x + 0.5 - 0.5 * settings.width) / focal,
                      -(y + 0.5 - 0.5 * settings.height) / focal, -1) *
           depth;
  };
  double sum = 0;
  int count = 0;
  for (int y = 3; y + 3 < settings.height; ++y) {
    for (int x = 3; x + 3 < settings.width; ++x) {
      const glm::dvec3 n(Pixel(frame.guides.normal, x, y));
      const bool all = frame.guides.id(x - 3, y) != 0 && frame.guides.id(x + 3, y) != 0 &&
                       frame.guides.id(x, y - 3) != 0 && frame.guides.id(x, y + 3) != 0;
      if (frame.guides.id(x, y) == 0 || !all || n.z < 0.6) {
        continue;
      }
      const glm::dvec3 across =
          glm::cross(point(x + 3, y) - point(x - 3, y), point(x, y - 3) - point(x, y + 3));
      const glm::dvec3 expected = across / std::sqrt(glm::dot(across, across));
      const double error = glm::dot(expected - n, expected - n);
      sum += error;
      ++count;
      ASSERT_LT(error, 0.01) << x << ' ' << y;
    }
  }
  EXPECT_GT(count, 1000);
  EXPECT_LT(sum / count, 1e-3);
}

TEST(DeformingFrameTest, IsTheFrameOfTheBakedScene) {
  // Few triangles are in one BVH, many in one for each instance.
  for (const int rings : {10, 60}) {
    const Scene scene = DeformingScene(rings);
    const RenderSettings settings = SmallSettings(kWidth, kHeight, 2);
    auto renderer = CreateRenderer(scene, settings);
    ASSERT_TRUE(renderer.ok()) << renderer.status().message();
    for (const double seconds : {0.0, 0.13, 0.31}) {
      Frame frame;
      ASSERT_TRUE((*renderer)->RenderFrame(MomentAt(seconds, seconds - 0.1), &frame).ok());
      const Frame baked = RenderOne(Baked(scene, seconds), settings, MomentAt(seconds, seconds));
      int other = 0;
      ForPixels([&](int x, int y) {
        // Baking exchanges two corners of each triangle of the mirrored one, the third instance.
        if (rings == 10 && frame.guides.id(x, y) != 3) {
          ASSERT_EQ(frame.guides.depth(x, y), baked.guides.depth(x, y));
          ASSERT_EQ(Pixel(frame.guides.normal, x, y), Pixel(baked.guides.normal, x, y));
          ASSERT_EQ(Pixel(frame.emission, x, y), Pixel(baked.emission, x, y));
        }
        const bool same_depth =
            std::abs(frame.guides.depth(x, y) - baked.guides.depth(x, y)) < 1e-4f ||
            frame.guides.depth(x, y) == baked.guides.depth(x, y);
        const vec3 light = Pixel(frame.signals[0].radiance, x, y);
        const vec3 expected = Pixel(baked.signals[0].radiance, x, y);
        const float difference = MaxComponent(abs(light - expected));
        other += same_depth && difference <= 2e-3f * (1 + MaxComponent(expected)) ? 0 : 1;
      });
      // Rounding sends some paths another way.
      EXPECT_LE(other, kWidth * kHeight / 100) << rings << " rings at " << seconds;
    }
  }
}

TEST(DeformingFrameTest, DependsOnNoFrameBefore) {
  const Scene scene = DeformingScene(10);
  const RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  auto renderer = CreateRenderer(scene, settings);
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  // Onwards, backwards, without a step, and far.
  const double times[][2] = {{0, 0}, {0.1, 0}, {0.2, 0.1}, {0.2, 0.2}, {0.1, 0.2}, {0.4, 0.3}};
  for (const auto& [now, before] : times) {
    ASSERT_TRUE((*renderer)->RenderFrame(MomentAt(now, before), &frame).ok());
    const Frame fresh = RenderOne(scene, settings, MomentAt(now, before));
    EXPECT_TRUE(SameLight(frame, fresh)) << now;
    EXPECT_TRUE(SameBits(frame.guides.motion[0], fresh.guides.motion[0])) << now;
    EXPECT_TRUE(SameBits(frame.guides.previous_normal, fresh.guides.previous_normal)) << now;
  }
}

TEST(DeformingFrameTest, TheNumberOfThreadsDoesNotMatter) {
  for (const int rings : {10, 60}) {
    const Scene scene = DeformingScene(rings);
    const RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
    Frame one;
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
      one = RenderOne(scene, settings, MomentAt(0.2, 0.1));
    }
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
    const Frame four = RenderOne(scene, settings, MomentAt(0.2, 0.1));
    EXPECT_TRUE(SameLight(one, four)) << rings;
    EXPECT_TRUE(SameBits(one.guides.motion[0], four.guides.motion[0])) << rings;
    EXPECT_TRUE(SameBits(one.guides.previous_normal, four.guides.previous_normal)) << rings;
  }
}

// A mesh whose pose changes now and then, while something else moves: its BVH is rebuilt only then.
TEST(DeformingFrameTest, MayStandWhileOthersMove) {
  Scene scene = DeformingScene(60);
  for (AnimationChannel& channel : scene.animation) {
    if (channel.property == AnimatedProperty::kRotation) {
      channel.interpolation = Interpolation::kStep;
    }
  }
  const RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  auto renderer = CreateRenderer(scene, settings);
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  for (const double now : {0.02, 0.05, 0.12, 0.17, 0.02}) {
    ASSERT_TRUE((*renderer)->RenderFrame(MomentAt(now, now - 0.03), &frame).ok());
    EXPECT_TRUE(SameLight(frame, RenderOne(scene, settings, MomentAt(now, now - 0.03)))) << now;
  }
}

// Scattered rays alone find the same light of the lamp that grows as shadow rays do.
TEST(DeformingFrameTest, LampsThatDeformAreSampledWhereTheyAre) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-9, -1, 9), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  Mesh lamp = Quad(vec3(-1, 0, -4), vec3(2, 0, 0), vec3(0, 0, 2));
  AddTarget(&lamp, [](vec3 p) { return vec3(p.x, 0.3f, 0); });
  const int instance = builder.Add(lamp, Emitter(vec3(5)));
  AnimateWeights(&builder, builder.InstanceNode(instance), {-0.5f}, {1});
  RenderSettings settings = SmallSettings(16, 12, 1);
  const RenderMoment moment = MomentAt(0.8, 0.0);
  vec3 means[2];
  for (int i = 0; i < 2; ++i) {
    settings.light_sampling = i == 0 ? LightSampling::kBsdf : LightSampling::kLight;
    auto renderer = CreateRenderer(builder.scene, settings);
    ASSERT_TRUE(renderer.ok());
    Image3 image;
    ASSERT_TRUE((*renderer)->RenderReference({}, 1, &image).ok());  // the rest at another time
    ASSERT_TRUE((*renderer)->RenderReference(moment, 512, &image).ok());
    means[i] = Mean(image);
  }
  EXPECT_GT(means[0].x, 0.02f);
  EXPECT_NEAR(means[0].x / means[1].x, 1.0f, 0.03f);
}

TEST(DeformingFrameTest, FocusFollowsTheDeformation) {
  SceneBuilder builder;
  Mesh sheet = Quad(vec3(-5, -5, -4), vec3(10, 0, 0), vec3(0, 10, 0));
  AddTarget(&sheet, [](vec3) { return vec3(0, 0, -2); });
  const int instance = builder.Add(sheet, Lambert(vec3(0.5f)));
  AnimateWeights(&builder, builder.InstanceNode(instance), {0}, {1});
  SceneState state(builder.scene);
  state.Update(0.5, 0.25);
  const CameraView view = MakeCameraView(builder.scene.cameras[0], mat4(1.0f), 8, 8);
  EXPECT_NEAR(FindFocus(state, view, false), 5.0f, 1e-5f);
  EXPECT_NEAR(FindFocus(state, view, true), 4.5f, 1e-5f);
}

TEST(DeformingSceneTest, FaultsAreNamed) {
  const auto message = [](auto change) {
    Scene scene = DeformingScene(4);
    change(&scene);
    const auto renderer = CreateRenderer(scene, SmallSettings(8, 8, 1));
    return renderer.ok() ? std::string() : renderer.status().message();
  };
  EXPECT_EQ(message([](Scene*) {}), "");
  EXPECT_THAT(message([](Scene* s) { s->meshes[1].joints.pop_back(); }), HasSubstr("mesh 1"));
  EXPECT_THAT(message([](Scene* s) { s->meshes[1].weights[0] = -1; }),
              HasSubstr("a joint of weight -1, expected 0 to 1"));
  EXPECT_THAT(message([](Scene* s) { s->meshes[1].joints[1] = 2; }),
              HasSubstr("its mesh uses 3 joints, its skin has 2"));
  EXPECT_THAT(message([](Scene* s) { s->skins[0].joints[0] = 99; }), HasSubstr("joint 0 is 99"));
  EXPECT_THAT(message([](Scene* s) { s->skins[0].inverse_bind.clear(); }),
              HasSubstr("skin 0 (\"\") has 2 joints and 0 matrices"));
  EXPECT_THAT(message([](Scene* s) { s->instances[1].skin = 7; }), HasSubstr("its skin is 7"));
  EXPECT_THAT(message([](Scene* s) { s->meshes[4].targets[0].vertices[1] = 0; }),
              HasSubstr("morph target 0 moves vertex 0 at position 1"));
  EXPECT_THAT(message([](Scene* s) { s->meshes[4].targets[0].positions.pop_back(); }),
              HasSubstr("morph target 0"));
  EXPECT_THAT(
      message([](Scene* s) { s->nodes[static_cast<size_t>(s->instances[4].node)].weights = {1}; }),
      HasSubstr("its node has 1 weights, its mesh 2 morph targets"));
  EXPECT_THAT(message([](Scene* s) {
                for (AnimationChannel& channel : s->animation) {
                  if (channel.property == AnimatedProperty::kWeights) {
                    channel.weights.pop_back();
                  }
                }
              }),
              HasSubstr("weights for 2 keys, expected"));
}

TEST(DeformingSceneTest, JointsBeyondTheLimitAreNamed) {
  SceneBuilder builder;
  const int instance = builder.Add(Tube(4, 8, 0.3f), Lambert(vec3(0.5f)));
  builder.Move(AddSkin(&builder, instance, At(vec3(0, 0, -4))), vec3(3e38f, 0, 0));
  auto renderer = CreateRenderer(builder.scene, SmallSettings(8, 8, 1));
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  const Status status = (*renderer)->RenderFrame(MomentAt(1.0, 0.0), &frame);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("its transform to the world"));
}

}  // namespace
}  // namespace stillray::render::deforming_test
