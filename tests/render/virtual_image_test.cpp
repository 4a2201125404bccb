// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Virtual guides: what mirrors and glass show, against analytic images in double precision.
#include "render/virtual_image.h"

#include <cmath>
#include <limits>

#include "scene/builtin.h"
#include "test_scenes.h"

namespace stillray::render::virtual_image_test {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr int kWidth = 120;
constexpr int kHeight = 90;

RenderSettings Size() {
  return SmallSettings(kWidth, kHeight, 1);
}

/// The camera of SceneBuilder at a place, looking along -z.
struct Pinhole {
  dvec3 eye{0.0};
  double focal = kHeight * 0.5 / std::tan(0.4);

  dvec3 Direction(dvec2 p) const {
    return glm::normalize(
        dvec3((p.x - 0.5 * kWidth) / focal, -(p.y - 0.5 * kHeight) / focal, -1.0));
  }
  dvec2 Project(dvec3 point) const {
    const dvec3 v = point - eye;
    return {0.5 * kWidth - v.x / v.z * focal, 0.5 * kHeight + v.y / v.z * focal};
  }
};

dvec2 Centre(int x, int y) {
  return {x + 0.5, y + 0.5};
}

dvec2 MotionAt(const VirtualGuides& image, int x, int y) {
  return {image.motion[0](x, y), image.motion[1](x, y)};
}

/// A point behind the plane through `at` with this normal, or before it.
dvec3 Mirrored(dvec3 point, dvec3 at, dvec3 normal) {
  return point - 2.0 * glm::dot(point - at, normal) * normal;
}

/// A mirror at z = -4 that turns about the y axis, opposite a wall at z = 3 that moves; the camera
/// moves too.
struct MirrorRoom {
  SceneBuilder builder;
  double turn = 0.05;  // radians per second
  dvec3 wall_velocity{0.3, -0.2, 0.0};
  dvec3 camera_velocity{0.1, 0.05, -0.2};

  MirrorRoom() {
    const int mirror = builder.Add(Quad(vec3(-6, -6, 0), vec3(12, 0, 0), vec3(0, 12, 0)),
                                   Metal(vec3(0.8f, 0.9f, 1.0f), 0.0f), At(vec3(0, 0, -4)));
    AnimationChannel rotation;
    rotation.node = builder.InstanceNode(mirror);
    rotation.property = AnimatedProperty::kRotation;
    rotation.times = {0.0f, 1.0f};
    const auto angle = static_cast<float>(turn);
    rotation.values = {Rotation(vec3(0, 1, 0), 0.0f), Rotation(vec3(0, 1, 0), angle)};
    builder.scene.animation.push_back(rotation);
    const int wall = builder.Add(Quad(vec3(40, -40, 0), vec3(-80, 0, 0), vec3(0, 80, 0)),
                                 Lambert(vec3(0.5f, 0.25f, 0.75f)), At(vec3(0, 0, 3)));
    builder.Move(builder.InstanceNode(wall), vec3(wall_velocity));
    builder.Move(0, vec3(camera_velocity));
  }
  dvec3 MirrorNormal(double seconds) const {
    return {std::sin(turn * seconds), 0.0, std::cos(turn * seconds)};
  }
};

TEST(VirtualImageTest, APlanarMirrorShowsTheReflectedWorld) {
  const MirrorRoom room;
  const double now = 1.0;
  const double before = 0.5;
  const Frame frame = RenderOne(room.builder.scene, Size(), MomentAt(now, before));
  ASSERT_FALSE(frame.reflection.empty());
  const dvec3 at(0, 0, -4);
  const Pinhole camera = {room.camera_velocity * now};
  const Pinhole previous = {room.camera_velocity * before};
  for (int y = 5; y < kHeight; y += 20) {
    for (int x = 5; x < kWidth; x += 20) {
      // The image of the wall is a plane behind the mirror.
      const dvec3 n = room.MirrorNormal(now);
      const dvec3 d = camera.Direction(Centre(x, y));
      const dvec3 image_normal = dvec3(0, 0, -1) - 2.0 * glm::dot(dvec3(0, 0, -1), n) * n;
      const dvec3 image_point = Mirrored(dvec3(0, 0, 3), at, n);
      const double t = glm::dot(image_point - camera.eye, image_normal) / glm::dot(d, image_normal);
      const dvec3 image = camera.eye + d * t;
      EXPECT_NEAR(frame.reflection.depth(x, y), -d.z * t, 1e-4 * t) << x << ", " << y;
      // The same point of the wall in the previous mirror.
      const dvec3 wall_point = Mirrored(image, at, n) - room.wall_velocity * (now - before);
      const dvec3 old_image = Mirrored(wall_point, at, room.MirrorNormal(before));
      const dvec2 expected = previous.Project(old_image) - Centre(x, y);
      const dvec2 got = MotionAt(frame.reflection, x, y);
      EXPECT_GT(glm::length(expected), 1.0);  // it moves
      EXPECT_LT(glm::length(got - expected), 0.02) << x << ", " << y;
      EXPECT_NEAR(frame.reflection.normal[2](x, y), -1, 1e-5);
      EXPECT_NEAR(frame.reflection.albedo[0](x, y), 0.5, 1e-5);
      EXPECT_EQ(frame.reflection.id(x, y), 2u);
    }
  }
}

// A ball of radius 1 about (0, 0, -4) in a box of 5 to each side of the origin.
const dvec3 kBall(0, 0, -4);
constexpr double kBox = 5;

double HitSphere(dvec3 o, dvec3 d, bool far) {
  const dvec3 v = o - kBall;
  const double b = glm::dot(v, d);
  const double root = b * b - glm::dot(v, v) + 1;
  return root < 0 ? -1 : -b + (far ? 1 : -1) * std::sqrt(root);
}

dvec3 HitBox(dvec3 o, dvec3 d) {
  double t = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    if (d[i] != 0) {
      t = std::min(t, ((d[i] > 0 ? kBox : -kBox) - o[i]) / d[i]);
    }
  }
  return o + d * t;
}

dvec3 Refracted(dvec3 d, dvec3 n, double ratio) {
  const double cosine = -glm::dot(d, n);
  const double sin2 = ratio * ratio * (1 - cosine * cosine);
  return ratio * d + (ratio * cosine - std::sqrt(std::max(1 - sin2, 0.0))) * n;
}

/// The point of the box that a pixel shows in the ball. \return false beside the ball
bool ShootAtBall(const Pinhole& camera, dvec2 p, bool glass, dvec3* seen) {
  const dvec3 d = camera.Direction(p);
  const double t = HitSphere(camera.eye, d, false);
  if (t < 0) {
    return false;
  }
  const dvec3 in = camera.eye + d * t;
  const dvec3 n = in - kBall;
  if (!glass) {
    *seen = HitBox(in, d - 2.0 * glm::dot(d, n) * n);
    return true;
  }
  const dvec3 inside = Refracted(d, n, 1 / 1.5);
  const dvec3 out = in + inside * HitSphere(in, inside, true);
  *seen = HitBox(out, Refracted(inside, kBall - out, 1.5));
  return true;
}

/// The pixel that showed this point, near p. \return false if there is none
bool FindInBall(const Pinhole& camera, dvec3 wanted, bool glass, dvec2* p) {
  for (int i = 0; i < 30; ++i) {
    constexpr double kStep = 1e-4;
    dvec3 seen;
    dvec3 right;
    dvec3 down;
    if (!ShootAtBall(camera, *p, glass, &seen) ||
        !ShootAtBall(camera, *p + dvec2(kStep, 0), glass, &right) ||
        !ShootAtBall(camera, *p + dvec2(0, kStep), glass, &down)) {
      return false;
    }
    const dvec3 a = (right - seen) / kStep;
    const dvec3 b = (down - seen) / kStep;
    const dvec3 miss = wanted - seen;
    const double aa = glm::dot(a, a);
    const double ab = glm::dot(a, b);
    const double bb = glm::dot(b, b);
    const double det = aa * bb - ab * ab;
    *p += dvec2(glm::dot(a, miss) * bb - glm::dot(b, miss) * ab,
                glm::dot(b, miss) * aa - glm::dot(a, miss) * ab) /
          det;
    if (glm::length(miss) < 1e-9) {
      return true;
    }
  }
  return false;
}

/// Mean and largest error of the motion of images in the ball, in pixels.
void ExpectMotionInBall(const Material& material, bool glass, double largest) {
  SceneBuilder builder;
  builder.Add(MakeSphere(1, 96, 64, 0), material, At(vec3(kBall)));
  builder.Add(Box(vec3(-kBox), vec3(kBox), true), Lambert(vec3(0.5f)));
  const dvec3 velocity(0.08, 0.03, 0.05);
  builder.Move(0, vec3(velocity));
  const Frame frame = RenderOne(builder.scene, Size(), MomentAt(1.0, 0.0));
  const VirtualGuides& image = glass ? frame.refraction : frame.reflection;
  const Pinhole now = {velocity};
  const Pinhole before = {dvec3(0.0)};
  int compared = 0;
  for (int y = 2; y < kHeight; y += 3) {
    for (int x = 2; x < kWidth; x += 3) {
      dvec3 seen;
      dvec3 beside;
      const dvec2 offset = Centre(x, y) - now.Project(kBall);
      if (glm::length(offset) > 19 || !ShootAtBall(now, Centre(x, y), glass, &seen) ||
          !ShootAtBall(now, Centre(x, y) + dvec2(1.5, 1.5), glass, &beside)) {
        continue;  // the ball has a radius of 27 pixels; near its edge images are tiny
      }
      dvec2 place = Centre(x, y);
      const bool one_wall = glm::length(beside - seen) < 1;
      if (!one_wall || !FindInBall(before, seen, glass, &place)) {
        continue;
      }
      const dvec2 expected = place - Centre(x, y);
      EXPECT_GT(image.depth(x, y), 4) << x << ", " << y;
      EXPECT_LT(glm::length(MotionAt(image, x, y) - expected), largest)
          << x << ", " << y << " expected " << expected.x << ", " << expected.y << " got "
          << image.motion[0](x, y) << ", " << image.motion[1](x, y);
      ++compared;
    }
  }
  EXPECT_GT(compared, 25);
}

TEST(VirtualImageTest, ImagesInAChromeBallMoveLikeAnalyticOnes) {
  ExpectMotionInBall(Metal(vec3(0.9f), 0.0f), false, 0.5);
}

TEST(VirtualImageTest, ImagesInAGlassBallMoveLikeAnalyticOnes) {
  ExpectMotionInBall(Glass(1.5f, 0.0f), true, 0.5);
}

TEST(VirtualImageTest, TheSkyInAMirrorIsInfinitelyFar) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-6, -6, -4), vec3(12, 0, 0), vec3(0, 12, 0)), Metal(vec3(0.5f), 0.05f));
  builder.scene.environment.radiance = vec3(2.0f, 3.0f, 4.0f);
  const Frame frame = RenderOne(builder.scene, Size());
  EXPECT_EQ(frame.reflection.depth(60, 45), std::numeric_limits<float>::infinity());
  EXPECT_EQ(Pixel(frame.reflection.albedo, 60, 45), vec3(2.0f, 3.0f, 4.0f));
  EXPECT_EQ(frame.reflection.motion[0](60, 45), 0);
  EXPECT_EQ(frame.reflection.id(60, 45), 0u);
}

TEST(VirtualImageTest, GlassShowsTheLightThatItReflects) {
  // A pane before a dark wall, and a small lamp behind the camera.
  SceneBuilder builder;
  builder.Add(Box(vec3(-6, -6, -4.5f), vec3(6, 6, -4)), Glass(1.5f, 0.0f));
  builder.Add(Quad(vec3(-40, -40, -9), vec3(80, 0, 0), vec3(0, 80, 0)), Lambert(vec3(0.3f)));
  builder.Add(Quad(vec3(0.5f, -0.5f, 1), vec3(-1, 0, 0), vec3(0, 1, 0)), Emitter(vec3(20.0f)));
  builder.scene.environment.radiance = vec3(0.1f);
  const Frame frame = RenderOne(builder.scene, Size());
  EXPECT_EQ(frame.reflection.id(60, 45), 3u);
  EXPECT_EQ(Pixel(frame.reflection.albedo, 60, 45), vec3(20.0f));
  EXPECT_NEAR(frame.reflection.depth(60, 45), 9, 1e-3);
  // Its other face reflects the lamp too, into transmitted light.
  EXPECT_EQ(frame.refraction.id(60, 45), 3u);
  EXPECT_EQ(frame.refraction.depth(60, 45), frame.reflection.depth(60, 45));
  EXPECT_EQ(frame.refraction.id(5, 5), 2u);  // through the pane
  EXPECT_NEAR(frame.refraction.motion[0](5, 5), 0, 0.01);
  EXPECT_EQ(frame.reflection.id(5, 5), 0u);
}

TEST(VirtualImageTest, APaneShowsTheWorldBehindIt) {
  SceneBuilder builder;
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  builder.Add(Quad(vec3(-6, -6, -4), vec3(12, 0, 0), vec3(0, 12, 0)), sheet);
  builder.Add(Quad(vec3(-40, -40, -9), vec3(80, 0, 0), vec3(0, 80, 0)), Lambert(vec3(0.3f)));
  const dvec3 velocity(0.2, -0.1, 0.3);
  builder.Move(0, vec3(velocity));
  const Frame frame = RenderOne(builder.scene, Size(), MomentAt(1.0, 0.0));
  const Pinhole now = {velocity};
  for (const int x : {10, 60, 100}) {
    const dvec3 d = now.Direction(Centre(x, 20));
    const dvec3 seen = now.eye + d * ((-9 - now.eye.z) / d.z);
    const dvec2 expected = Pinhole().Project(seen) - Centre(x, 20);
    EXPECT_LT(glm::length(MotionAt(frame.refraction, x, 20) - expected), 0.01) << x;
    EXPECT_NEAR(frame.refraction.depth(x, 20), 9 + velocity.z, 1e-3);
    EXPECT_EQ(frame.refraction.id(x, 20), 2u);
    EXPECT_NEAR(frame.refraction.albedo[1](x, 20), 0.3f, 1e-5f);
  }
}

TEST(VirtualImageTest, MirrorsThatFaceEachOtherShowNone) {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-6, -6, -4), vec3(12, 0, 0), vec3(0, 12, 0)), Metal(vec3(0.5f), 0.0f));
  builder.Add(Quad(vec3(60, -60, 3), vec3(-120, 0, 0), vec3(0, 120, 0)), Metal(vec3(0.5f), 0.0f));
  const Frame frame = RenderOne(builder.scene, Size());
  for (int y = 0; y < kHeight; y += 9) {
    for (int x = 0; x < kWidth; x += 9) {
      EXPECT_TRUE(std::isfinite(frame.reflection.motion[0](x, y)));
      EXPECT_FALSE(std::isnan(frame.reflection.depth(x, y)));
    }
  }
  EXPECT_EQ(frame.reflection.id(60, 45) == 0, !std::isfinite(frame.reflection.depth(60, 45)));
}

TEST(VirtualImageTest, OnlyReflectingSurfacesShowImages) {
  const auto depth = [](float roughness) {
    SceneBuilder builder;
    builder.Add(Quad(vec3(-6, -6, -4), vec3(12, 0, 0), vec3(0, 12, 0)),
                Metal(vec3(0.5f), roughness));
    builder.Add(Quad(vec3(-1, -1, -3.9f), vec3(0.5f, 0, 0), vec3(0, 0.5f, 0)),
                Metal(vec3(0.5f), 0.0f));
    builder.scene.environment.radiance = vec3(1.0f);
    return RenderOne(builder.scene, Size()).reflection.depth(60, 45);
  };
  EXPECT_GT(depth(0.1f), 0);
  EXPECT_GT(depth(kMostReflectingRoughness), 0);
  EXPECT_EQ(depth(kMostReflectingRoughness + 0.01f), 0);
}

TEST(VirtualImageTest, FramesHaveNoneWithoutSmoothSurfacesOrIfTheyAreOff) {
  SceneBuilder rough;
  rough.Add(Quad(vec3(-6, -6, -4), vec3(12, 0, 0), vec3(0, 12, 0)), Lambert(vec3(0.5f)));
  EXPECT_TRUE(RenderOne(rough.scene, Size()).reflection.empty());

  const MirrorRoom room;
  RenderSettings settings = Size();
  const Frame with = RenderOne(room.builder.scene, settings);
  EXPECT_FALSE(with.reflection.empty());
  settings.virtual_guides = false;
  const Frame without = RenderOne(room.builder.scene, settings);
  EXPECT_TRUE(without.reflection.empty());
  settings.virtual_guides = true;
  settings.cycle = 4;
  EXPECT_FALSE(RenderOne(room.builder.scene, settings).reflection.empty());
  settings.guides = GuideCoverage::kSparse;
  EXPECT_TRUE(RenderOne(room.builder.scene, settings).reflection.empty());
  // Light is the same.
  for (size_t k = 0; k < with.signals.size(); ++k) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(Pixel(with.signals[k].radiance, x, y), Pixel(without.signals[k].radiance, x, y));
      }
    }
  }
}

// A smooth clear coat over a rough surface shows the same image as a mirror, unless most of the
// specular light comes from below it.
TEST(VirtualImageTest, SmoothClearCoatsShowImages) {
  const auto image_of = [](const Material& material) {
    SceneBuilder builder;
    builder.Add(Quad(vec3(-6, -6, -4), vec3(12, 0, 0), vec3(0, 12, 0)), material);
    builder.Add(Quad(vec3(40, -40, 3), vec3(-80, 0, 0), vec3(0, 80, 0)), Lambert(vec3(0.5f)));
    return RenderOne(builder.scene, Size());
  };
  Material coated = Lambert(vec3(0.6f));
  coated.clearcoat = 1.0f;
  const Frame mirror = image_of(Metal(vec3(1.0f), 0.0f));
  const Frame coat = image_of(coated);
  Material metal = Metal(vec3(0.9f), 0.6f);
  metal.clearcoat = 1.0f;
  const Frame flakes = image_of(metal);
  ASSERT_GT(mirror.reflection.depth(60, 40), 0.0f);
  EXPECT_EQ(coat.reflection.depth(60, 40), mirror.reflection.depth(60, 40));
  EXPECT_EQ(coat.reflection.id(60, 40), mirror.reflection.id(60, 40));
  EXPECT_TRUE(flakes.reflection.depth.empty() || flakes.reflection.depth(60, 40) == 0.0f);
}

}  // namespace
}  // namespace stillray::render::virtual_image_test
