// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The fits against a room whose cameras are known. Layers have the precision of halves.
#include "io/camera_fit.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "core/cameras.h"
#include "mirror_room.h"

namespace stillray::io::camera_fit_test {
namespace {

/// A camera that moves, turns and zooms.
RoomCamera Now() {
  RoomCamera camera;
  camera.position = {0.1, 1.5, -4.0};
  camera.pan = 0.05;
  camera.shift = {0.06, -0.03};
  return camera;
}

RoomCamera Before() {
  RoomCamera camera;
  camera.position = {-0.05, 1.46, -4.15};
  camera.pan = 0.02;
  camera.tilt = 0.01;
  camera.tangent = 0.61;
  camera.shift = {0.06, -0.03};
  return camera;
}

RoomPicture Picture(const Room& room, const RoomOptions& options = {}) {
  return Trace(room, Now(), Before(), options);
}

TEST(FitLens, FindsFocalLengthClippingPlaneAndShift) {
  RoomOptions options;
  options.clip_start = 0.25;
  for (const Room& room : {EmptyRoom(), RoomWithMirror()}) {
    for (const bool tall : {false, true}) {
      options.width = tall ? 120 : 160;
      options.height = tall ? 160 : 120;
      const RoomPicture picture = Picture(room, options);
      const std::optional<Lens> lens = FitLens(picture.frame.guides.depth, picture.seen.depth);
      ASSERT_TRUE(lens.has_value());
      EXPECT_NEAR(lens->k, 0.36, 0.001);
      EXPECT_NEAR(lens->start, 0.25, 0.003);
      EXPECT_NEAR(lens->centre.x, 0.06, 0.003);
      EXPECT_NEAR(lens->centre.y, -0.03, 0.003);
    }
  }
}

TEST(FitLens, TurnsDistancesIntoDepths) {
  const RoomPicture picture = Picture(RoomWithMirror());
  const std::optional<Lens> lens = FitLens(picture.frame.guides.depth, picture.seen.depth);
  ASSERT_TRUE(lens.has_value());
  const Lens known = {0.36, 0.1, {0.06, -0.03}};
  for (const vec2& p : {vec2(-1, -0.7f), vec2(0, 0), vec2(0.9f, 0.2f)}) {
    for (const double distance : {0.5, 7.0, 40.0}) {
      EXPECT_NEAR(lens->DepthOf(distance, p) / known.DepthOf(distance, p), 1, 0.003);
    }
  }
}

TEST(FitView, FindsTheFieldOfView) {
  for (const double tangent : {0.3, 0.6, 1.0}) {
    RoomCamera camera = Now();
    camera.shift = {0, 0};
    camera.tangent = tangent;
    const Guides g = Trace(RoomWithMirror(), camera, camera).frame.guides;
    const std::optional<View> fit = FitView(g.depth, g.normal);
    ASSERT_TRUE(fit.has_value());
    EXPECT_NEAR(fit->tangent, tangent, 0.04 * tangent);
    const vec3 floor = fit->to_camera * vec3(0, 1, 0);
    EXPECT_NEAR(floor.x, 0, 0.02f);
    EXPECT_NEAR(floor.y, -1, 0.02f);  // down is positive
    EXPECT_NEAR(floor.z, 0, 0.02f);
  }
}

// A renderer's normals may be in other axes than its camera.
TEST(FitView, AxesDoNotMatter) {
  RoomCamera camera = Now();
  camera.shift = {0, 0};
  const Guides g = Trace(RoomWithMirror(), camera, camera).frame.guides;
  Image3 turned = g.normal;
  turned[0] = g.normal[2];
  turned[1] = g.normal[0];
  for (int y = 0; y < turned.height(); ++y) {
    for (int x = 0; x < turned.width(); ++x) {
      turned[2](x, y) = -g.normal[1](x, y);
    }
  }
  const std::optional<View> fit = FitView(g.depth, turned);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->tangent, 0.6, 0.02);
  EXPECT_NEAR((fit->to_camera * vec3(0, 0, -1)).y, -1, 0.02f);  // the floor
}

TEST(FitView, FindsNoneInRandomNormalsAndOnOnePlane) {
  RoomCamera camera = Now();
  camera.shift = {0, 0};
  const Guides g = Trace(RoomWithMirror(), camera, camera).frame.guides;
  Image3 random = g.normal;
  std::minstd_rand numbers;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < random.height(); ++y) {
      for (int x = 0; x < random.width(); ++x) {
        random[c](x, y) = static_cast<float>(numbers() % 2001) * 5e-4f - 0.5f;
      }
    }
  }
  EXPECT_FALSE(FitView(g.depth, random).has_value());
  EXPECT_FALSE(FitView(Image1(4, 4), Image3(4, 4)).has_value());
  Image1 wall(64, 48);
  wall.Fill(3);
  Image3 facing(64, 48);
  facing[2].Fill(-1);
  EXPECT_FALSE(FitView(wall, facing).has_value());
}

TEST(FitLens, ParallelRays) {
  const RoomPicture picture = Picture(EmptyRoom());
  const Image1& depth = picture.frame.guides.depth;
  Image1 distance = depth;
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      distance(x, y) = RoundToHalf(static_cast<double>(depth(x, y)) - 0.5);
    }
  }
  const std::optional<Lens> lens = FitLens(depth, distance);
  ASSERT_TRUE(lens.has_value());
  EXPECT_NEAR(lens->k, 0, 0.001);
  EXPECT_NEAR(lens->start, 0.5, 0.01);
}

/// Uniform values between `from` and `to`.
Image1 RandomPlane(int width, int height, float from, float to, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(from, to);
  Image1 plane(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      plane(x, y) = uniform(random);
    }
  }
  return plane;
}

TEST(FitLens, FindsNoneInRandomDistances) {
  const RoomPicture picture = Picture(EmptyRoom());
  const Image1& depth = picture.frame.guides.depth;
  EXPECT_FALSE(FitLens(depth, RandomPlane(160, 120, 1, 20, 1)).has_value());
  EXPECT_FALSE(FitLens(depth, Image1(160, 120)).has_value());
  Image1 nothing(160, 120);
  nothing.Fill(std::nanf(""));
  EXPECT_FALSE(FitLens(depth, nothing).has_value());
  EXPECT_FALSE(FitLens(nothing, picture.seen.depth).has_value());
}

/// The largest error of a fit's motion, in pixels, over pixels of the picture and `depths`.
double WorstError(const CameraMotion& fit, const std::vector<double>& depths) {
  double worst = 0;
  for (int y = 3; y < 120; y += 9) {
    for (int x = 3; x < 160; x += 9) {
      const glm::dvec2 p = PointOfPixel(160, 120, x, y);
      for (const double z : depths) {
        const glm::dvec3 point = Now().position + z * Now().Ray(p);
        const glm::dvec2 known = (Before().Project(point) - p) * 80.0;
        worst = std::max(worst, glm::length(glm::dvec2(fit.MotionOf(vec2(p), z, 160)) - known));
      }
    }
  }
  return worst;
}

TEST(FitCameraMotion, KnowsTheMotionOfPointsAtAllDepths) {
  for (const Room& room : {EmptyRoom(), RoomWithMirror()}) {
    const RoomPicture picture = Picture(room);
    const std::optional<CameraMotion> fit =
        FitCameraMotion(picture.frame.guides.depth, picture.frame.guides.motion);
    ASSERT_TRUE(fit.has_value());
    EXPECT_LT(WorstError(*fit, {2.5, 5, 10}), 0.02);
    EXPECT_LT(WorstError(*fit, {15, 30, 1e9}), 0.02);
    // Without the fit the error would be pixels.
    EXPECT_GT(WorstError(CameraMotion{glm::dmat4x3(1.0), 1}, {5}), 1);
  }
}

TEST(FitCameraMotion, AMovingObjectDoesNotCount) {
  Room room = EmptyRoom();
  room.rectangles.push_back(MovingBoard());
  const RoomPicture picture = Picture(room);
  int covered = 0;
  int surfaces = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      covered += picture.frame.guides.id(x, y) == room.rectangles.size() ? 1 : 0;
      surfaces += picture.what(x, y) != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(covered, 0.25 * surfaces);
  const std::optional<CameraMotion> fit =
      FitCameraMotion(picture.frame.guides.depth, picture.frame.guides.motion);
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(WorstError(*fit, {3, 10, 20, 1e9}), 0.02);
}

TEST(FitCameraMotion, FindsNoneInRandomMotion) {
  const RoomPicture picture = Picture(EmptyRoom());
  Image2 motion(160, 120);
  motion[0] = RandomPlane(160, 120, -9, 9, 1);
  motion[1] = RandomPlane(160, 120, -9, 9, 2);
  EXPECT_FALSE(FitCameraMotion(picture.frame.guides.depth, motion).has_value());
  motion[0].Fill(std::nanf(""));
  EXPECT_FALSE(FitCameraMotion(picture.frame.guides.depth, motion).has_value());
  EXPECT_FALSE(FitCameraMotion(Image1(160, 120), picture.frame.guides.motion).has_value());
}

TEST(FitCameraMotion, HugeMotionDoesNoHarm) {
  RoomPicture picture = Picture(EmptyRoom());
  Image2& motion = picture.frame.guides.motion;
  for (int x = 0; x < 160; x += 3) {
    motion[0](x, 60) = 3e38f;
    motion[1](x, 61) = -1e30f;
  }
  const std::optional<CameraMotion> fit = FitCameraMotion(picture.frame.guides.depth, motion);
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(WorstError(*fit, {3, 20}), 0.02);
}

TEST(FitCameraMotion, ACameraThatStandsMovesNothing) {
  const RoomPicture picture = Trace(EmptyRoom(), Now(), Now());
  const std::optional<CameraMotion> fit =
      FitCameraMotion(picture.frame.guides.depth, picture.frame.guides.motion);
  ASSERT_TRUE(fit.has_value());
  for (const double z : {0.5, 7.0, 1e9}) {
    const vec2 motion = fit->MotionOf({0.7f, -0.4f}, z, 160);
    EXPECT_NEAR(motion.x, 0, 1e-6);
    EXPECT_NEAR(motion.y, 0, 1e-6);
  }
}

/// A plane that fills the picture.
Room OnePlane(const RoomRectangle& plane) {
  Room room;
  room.rectangles = {plane};
  return room;
}

const RoomRectangle kFrontal = {{-50, -50, 6},      {100, 0, 0},     {0, 100, 0},
                                RoomSurface::kMatt, glm::dvec3(0.5), glm::dvec3(0.0)};
const RoomRectangle kNear = {{-50, -50, -3.9},   {100, 0, 0},     {0, 100, 0},
                             RoomSurface::kMatt, glm::dvec3(0.5), glm::dvec3(0.0)};
const RoomRectangle kSlanted = {{-50, -50, -8},     {100, 0, 20},    {0, 100, 8},
                                RoomSurface::kMatt, glm::dvec3(0.5), glm::dvec3(0.0)};

// Of one plane alone neither epipole nor horizon are known: points on it are right, others finite.
TEST(FitCameraMotion, OnePlaneGivesFiniteMotion) {
  for (const RoomRectangle& plane : {kFrontal, kNear, kSlanted}) {
    const RoomPicture picture = Picture(OnePlane(plane));
    const Guides& g = picture.frame.guides;
    const std::optional<CameraMotion> fit = FitCameraMotion(g.depth, g.motion);
    ASSERT_TRUE(fit.has_value());
    EXPECT_TRUE(fit->of_one_plane);
    const vec2 on_plane = fit->MotionOf(vec2(PointOfPixel(160, 120, 20, 30)),
                                        static_cast<double>(g.depth(20, 30)), 160);
    EXPECT_NEAR(on_plane.x, g.motion[0](20, 30), 0.1);
    EXPECT_NEAR(on_plane.y, g.motion[1](20, 30), 0.1);
    const vec2 other = fit->MotionOf({0.3f, 0.2f}, 100, 160);
    EXPECT_TRUE(std::isfinite(other.x) && std::isfinite(other.y));
    EXPECT_TRUE(FitLens(g.depth, picture.seen.depth).has_value());
    CameraFits fits(g);
    EXPECT_FALSE(fits.Motion().has_value());
    EXPECT_TRUE(fits.SeesOnePlane());
  }
}

// With the plane's 1 / z = a . (p, 1), the map H - e a^T with the epipole e moves its points as H
// does, for every e, and points at other depths otherwise.
TEST(FitCameraMotion, OnePlaneAllowsManyCameras) {
  const RoomPicture picture = Picture(OnePlane(kSlanted));
  const std::optional<CameraMotion> exact =
      MotionOfCamera(MatricesOf(Now(), 160, 120), MatricesOf(Before(), 160, 120), 160, 120);
  ASSERT_TRUE(exact.has_value());
  const glm::dvec3 normal = glm::cross(kSlanted.a, kSlanted.b);
  const double distance = glm::dot(normal, kSlanted.corner - Now().position);
  const auto nearness = [&](glm::dvec2 p) { return glm::dot(normal, Now().Ray(p)) / distance; };
  const glm::dvec3 a(nearness({1, 0}) - nearness({0, 0}), nearness({0, 1}) - nearness({0, 0}),
                     nearness({0, 0}));
  CameraMotion other = *exact;
  const glm::dvec3 e(0.3, -0.2, 0.1);
  for (int i = 0; i < 3; ++i) {
    other.map[i] -= e * a[i];
  }
  other.map[3] += e;
  for (const glm::dvec2& p : {glm::dvec2(-0.5, 0.3), glm::dvec2(0.6, -0.4)}) {
    const double z = 1 / nearness(p);
    EXPECT_LT(glm::length(exact->MotionOf(vec2(p), z, 160) - other.MotionOf(vec2(p), z, 160)),
              1e-4f);
    EXPECT_GT(
        glm::length(exact->MotionOf(vec2(p), 3 * z, 160) - other.MotionOf(vec2(p), 3 * z, 160)),
        0.5f);
  }
}

TEST(FitCameraMotion, APlaneThatStandsStillIsEnough) {
  const RoomPicture picture = Trace(OnePlane(kSlanted), Now(), Now());
  CameraFits fits(picture.frame.guides);
  ASSERT_TRUE(fits.Motion().has_value());
  EXPECT_LT(glm::length(fits.Motion()->MotionOf({0.3f, 0.2f}, 100, 160)), 1e-4f);
}

// A board that covers a fiftieth of the picture, a tenth nearer than the wall, is enough to
// determine the motion of the camera.
TEST(FitCameraMotion, ALittleReliefIsEnough) {
  Room room = OnePlane(kFrontal);
  room.rectangles.push_back({{-0.5, 1, 5},
                             {1.8, 0, 0},
                             {0, 1.3, 0},
                             RoomSurface::kMatt,
                             glm::dvec3(0.5),
                             glm::dvec3(0.0)});
  const RoomPicture picture = Picture(room);
  int covered = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      covered += picture.frame.guides.id(x, y) == 2 ? 1 : 0;
    }
  }
  EXPECT_LT(covered, 0.03 * 160 * 120);
  CameraFits fits(picture.frame.guides);
  ASSERT_TRUE(fits.Motion().has_value());
  EXPECT_FALSE(fits.SeesOnePlane());
  EXPECT_LT(WorstError(*fits.Motion(), {5, 10, 20, 1e9}), 0.1);
}

// The exact motion of known cameras against points that are projected one by one.
TEST(MotionOfCamera, IsThatOfAllPoints) {
  using Matrices = CameraMatrices (*)(const RoomCamera&, int, int);
  for (const Matrices matrices : {&MatricesOf, &MatricesOfOpenGl}) {
    const std::optional<CameraMotion> motion =
        MotionOfCamera(matrices(Now(), 160, 120), matrices(Before(), 160, 120), 160, 120);
    ASSERT_TRUE(motion.has_value());
    EXPECT_LT(WorstError(*motion, {0.5, 2.5, 5, 10, 1e9}), 1e-3);
    const glm::dmat4x3& map = motion->map;
    const glm::dvec3 eye = -glm::inverse(glm::dmat3(map[0], map[1], map[2])) * map[3];
    EXPECT_NEAR(eye.z, Now().InCamera(Before().position).z, 1e-9);
  }
}

TEST(MotionOfCamera, CamerasWithoutPerspectiveHaveNone) {
  const CameraMatrices now = MatricesOf(Now(), 160, 120);
  CameraMatrices parallel = now;
  for (size_t i = 0; i < 4; ++i) {
    parallel.world_to_ndc[4 * i + 3] = i == 3 ? 1 : 0;
  }
  EXPECT_TRUE(HasPerspective(now, 160, 120));
  EXPECT_FALSE(HasPerspective(parallel, 160, 120));
  EXPECT_FALSE(MotionOfCamera(now, parallel, 160, 120).has_value());
  EXPECT_FALSE(MotionOfCamera(parallel, now, 160, 120).has_value());
}

TEST(FitCameraMotion, TinyPictures) {
  for (const int size : {1, 2, 3}) {
    Image1 depth(size, size);
    depth.Fill(4);
    const std::optional<CameraMotion> fit = FitCameraMotion(depth, Image2(size, size));
    ASSERT_TRUE(fit.has_value());
    EXPECT_EQ(fit->MotionOf({0, 0}, 4, size).x, 0);
    (void)FitLens(depth, depth);
  }
}

/// Rotation by 0.7 radians about (1, 2, 2), then x flipped.
mat3 FlippedRotation() {
  const glm::dvec3 axis = glm::normalize(glm::dvec3(1, 2, 2));
  glm::dmat3 rotation(0.0);
  for (int i = 0; i < 3; ++i) {
    glm::dvec3 e(0.0);
    e[i] = 1;
    rotation[i] = std::cos(0.7) * e + std::sin(0.7) * glm::cross(axis, e) +
                  (1 - std::cos(0.7)) * glm::dot(axis, e) * axis;
    rotation[i].x = -rotation[i].x;
  }
  return mat3(rotation);
}

TEST(FitNormalMap, FindsARotationWithAFlippedAxis) {
  const mat3 known = FlippedRotation();
  ASSERT_NEAR(glm::determinant(known), -1, 1e-6);
  const RoomPicture picture = Picture(EmptyRoom());
  const Image3& normal = picture.frame.guides.normal;
  Image3 mapped(160, 120);
  std::mt19937 random(1);
  std::normal_distribution<float> gauss;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      vec3 value = known * vec3(normal[0](x, y), normal[1](x, y), normal[2](x, y));
      if (random() % 4 == 0) {  // mirrors
        value = glm::normalize(vec3(gauss(random), gauss(random), gauss(random)));
      }
      for (int c = 0; c < 3; ++c) {
        mapped[c](x, y) = x == 7 && y == 60 ? std::nanf("") : RoundToHalf(value[c]);
      }
    }
  }
  const mat3 map = FitNormalMap(normal, mapped);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(map[i][j], known[i][j], 0.005) << i << " " << j;
    }
  }
}

TEST(FitNormalMap, ValuesThatAreNoNormalsDoNotCount) {
  RoomCamera camera;
  camera.pan = -0.1;
  RoomPicture picture = Trace(RoomWithMirror(), camera, camera);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if ((x * 7 + y * 13) % 60 == 1) {
        picture.seen.normal[y % 3](x, y) = 3e38f;
      }
    }
  }
  const mat3 map = FitNormalMap(picture.frame.guides.normal, picture.seen.normal);
  EXPECT_NEAR(glm::determinant(map), -1, 0.01);
}

TEST(FitNormalMap, DirectionsThatNoNormalHasAreZero) {
  Image3 normal(8, 8);
  normal[1].Fill(1);
  const mat3 map = FitNormalMap(normal, normal);
  EXPECT_NEAR(map[1][1], 1, 1e-4);
  EXPECT_NEAR(glm::length(map[0]) + glm::length(map[2]), 0, 1e-4);
  EXPECT_EQ(FitNormalMap(Image3(8, 8), normal)[1][1], 0);
}

TEST(PicturePoint, RunsFromSideToSide) {
  EXPECT_EQ(PicturePoint(160, 120, 0, 60), vec2(-1, 0));
  EXPECT_EQ(PicturePoint(160, 120, 160, 120), vec2(1, 0.75f));
}

}  // namespace
}  // namespace stillray::io::camera_fit_test
