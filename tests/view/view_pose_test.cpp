// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_pose.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::view::view_pose_test {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

void ExpectNear(vec3 a, vec3 b, float tolerance = 1e-5f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

ViewPose SomePose() {
  ViewPose pose;
  pose.position = {1, 2, 3};
  pose.yaw = 0.7f;
  pose.pitch = -0.4f;
  pose.yfov = 0.9f;
  pose.distance = 5;
  return pose;
}

TEST(ViewPose, ZeroAnglesLookAlongMinusZ) {
  const ViewPose pose;
  ExpectNear(pose.Forward(), {0, 0, -1});
  ExpectNear(pose.Right(), {1, 0, 0});
  ExpectNear(pose.Up(), {0, 1, 0});
}

TEST(ViewPose, PositiveYawTurnsLeftPositivePitchUp) {
  ViewPose pose;
  pose.yaw = kPi / 2;
  ExpectNear(pose.Forward(), {-1, 0, 0});
  pose.yaw = 0;
  pose.pitch = kPi / 4;
  EXPECT_GT(pose.Forward().y, 0.7f);
  EXPECT_LT(pose.Forward().y, 0.71f);
}

TEST(ViewPose, AxesAreOrthonormalAndRightHanded) {
  ViewPose pose = SomePose();
  pose.roll = 0.3f;
  ExpectNear(glm::cross(pose.Right(), pose.Up()), -pose.Forward());
  EXPECT_NEAR(glm::dot(pose.Right(), pose.Up()), 0, 1e-6f);
  EXPECT_NEAR(glm::length(pose.Up()), 1, 1e-6f);
}

TEST(ViewPose, SurvivesTheWayThroughAMatrix) {
  for (const float roll : {0.0f, 0.5f, -2.0f}) {
    for (const float pitch : {-1.5f, -0.3f, 0.0f, 1.2f}) {
      ViewPose pose = SomePose();
      pose.roll = roll;
      pose.pitch = pitch;
      const ViewPose back = PoseFromMatrix(ToMatrix(pose), pose.yfov, pose.distance);
      EXPECT_NEAR(back.yaw, pose.yaw, 1e-4f);
      EXPECT_NEAR(back.pitch, pose.pitch, 1e-4f);
      EXPECT_NEAR(back.roll, pose.roll, 1e-4f);
      ExpectNear(back.position, pose.position);
    }
  }
}

TEST(ViewPose, LookingStraightDownKeepsWhatIsUpInThePicture) {
  ViewPose pose;
  pose.pitch = -kPi / 2;
  pose.yaw = 1.0f;
  const ViewPose back = PoseFromMatrix(ToMatrix(pose), 0.8f, 1);
  ExpectNear(back.Up(), pose.Up(), 1e-3f);
  ExpectNear(back.Forward(), {0, -1, 0}, 1e-3f);
}

TEST(ViewPose, ScaledAndBrokenMatricesGiveFinitePoses) {
  const ViewPose scaled = PoseFromMatrix(ToMatrix(SomePose()) * mat4(3.0f), 0.8f, 1);
  ExpectNear(scaled.Forward(), SomePose().Forward(), 1e-4f);
  const ViewPose broken = PoseFromMatrix(mat4(0.0f), 0.8f, -1);
  EXPECT_TRUE(std::isfinite(broken.yaw + broken.pitch + broken.roll));
  EXPECT_GT(broken.distance, 0);
}

TEST(ViewPose, OrbitKeepsFocusAndDistance) {
  const ViewPose pose = SomePose();
  const ViewPose turned = Orbit(pose, 0.3f, -0.2f);
  ExpectNear(turned.Focus(), pose.Focus(), 1e-4f);
  EXPECT_NEAR(glm::length(turned.position - pose.Focus()), pose.distance, 1e-4f);
  EXPECT_GT(glm::length(turned.position - pose.position), 0.5f);
}

// A camera at (0, 1, 5) that looks at (0, 1, 0): a quarter turn leads to (radius, 1, 0).
TEST(ViewPose, OnOrbitCirclesCounterClockwiseFromAbove) {
  ViewPose pose;
  pose.position = {0, 1, 5};
  pose.distance = 5;
  ViewPose turned = OnOrbit(pose, kPi / 2, 0);
  ExpectNear(turned.position, {5, 1, 0});
  ExpectNear(turned.Forward(), {-1, 0, 0});
  turned = OnOrbit(pose, kPi / 2, 2);
  ExpectNear(turned.position, {2, 1, 0});
  EXPECT_NEAR(turned.distance, 2, 1e-5f);
  ExpectNear(OnOrbit(pose, 2 * kPi, 0).position, pose.position);
}

TEST(ViewPose, OnOrbitKeepsACentreBesideTheAxis) {
  ViewPose pose = SomePose();
  pose.aside = {1.5f, -0.5f};
  const vec3 focus = pose.Focus();
  for (const double angle : {0.3, -2.0, 100.0}) {
    const ViewPose turned = OnOrbit(pose, angle, 7);
    ExpectNear(turned.Focus(), focus, 2e-5f);
    EXPECT_NEAR(glm::length(turned.position - focus), 7, 1e-4f);
    EXPECT_EQ(turned.pitch, pose.pitch);
    // The centre stays at the same place of the picture.
    EXPECT_NEAR(turned.aside.x / turned.distance, pose.aside.x / pose.distance, 1e-5f);
  }
}

TEST(ViewPose, OrbitStopsAtThePoles) {
  ViewPose pose = SomePose();
  for (int i = 0; i < 100; ++i) {
    pose = Orbit(pose, 0, 0.1f);
  }
  EXPECT_NEAR(pose.pitch, -kPi / 2, 1e-6f);
  ExpectNear(pose.Focus(), SomePose().Focus(), 1e-3f);
}

TEST(ViewPose, LookTurnsInPlace) {
  const ViewPose turned = Look(SomePose(), 0.5f, 0.1f);
  ExpectNear(turned.position, SomePose().position, 0);
  EXPECT_FLOAT_EQ(turned.yaw, 0.2f);
  EXPECT_FLOAT_EQ(turned.pitch, -0.5f);
}

TEST(ViewPose, PanMovesTheFocusWithTheMouse) {
  const ViewPose pose = SomePose();
  constexpr float kHeight = 480;
  const ViewPose moved = Pan(pose, 40, -24, kHeight);
  // Where the old focus is seen now: right by 40 pixels, up by 24.
  const vec3 offset = pose.Focus() - moved.position;
  const float depth = glm::dot(offset, moved.Forward());
  const float pixels = kHeight / (2 * std::tan(pose.yfov / 2)) / depth;
  EXPECT_NEAR(glm::dot(offset, moved.Right()) * pixels, 40, 1e-2f);
  EXPECT_NEAR(glm::dot(offset, moved.Up()) * pixels, 24, 1e-2f);
}

TEST(ViewPose, DollyNeverReachesTheFocus) {
  ViewPose pose = SomePose();
  const vec3 focus = pose.Focus();
  const ViewPose near = Dolly(pose, 1);
  EXPECT_NEAR(near.distance, 4.5f, 1e-5f);
  ExpectNear(near.Focus(), focus, 1e-4f);
  for (int i = 0; i < 1000; ++i) {
    pose = Dolly(pose, 3);
  }
  EXPECT_GT(pose.distance, 0);
  ExpectNear(pose.Focus(), focus, 1e-3f);
  EXPECT_GT(Dolly(SomePose(), -1).distance, 5);
}

TEST(ViewPose, ZoomStaysWithinSensibleAngles) {
  ViewPose pose = SomePose();
  for (int i = 0; i < 200; ++i) {
    pose = Zoom(pose, -1);
  }
  EXPECT_LT(pose.yfov, kPi);
  for (int i = 0; i < 400; ++i) {
    pose = Zoom(pose, 1);
  }
  EXPECT_GT(pose.yfov, 0.01f);
}

TEST(ViewPose, FlyFollowsTheCamerasAxes) {
  const ViewPose pose = SomePose();
  ExpectNear(Fly(pose, 0, 0, 2).position, pose.position + pose.Forward() * 2.0f);
  ExpectNear(Fly(pose, 2, 0, 0).position, pose.position + pose.Right() * 2.0f);
  ExpectNear(Fly(pose, 0, 2, 0).position, pose.position + pose.Up() * 2.0f);
}

TEST(ViewPose, FocusOnTurnsToThePointThatWasClicked) {
  const ViewPose pose = SomePose();
  constexpr float kAspect = 1.6f;
  const float half = std::tan(pose.yfov / 2);
  // A point right of and above the middle, at depth 4.
  const vec3 point = pose.position + pose.Forward() * 4.0f +
                     pose.Right() * (0.5f * half * kAspect * 4) + pose.Up() * (0.25f * half * 4);
  const ViewPose focused = FocusOn(pose, 0.75f, 0.375f, kAspect, 4);
  ExpectNear(focused.Focus(), point, 1e-4f);
  ExpectNear(focused.position, pose.position, 0);
}

TEST(ViewPose, OrbitAroundLeavesTheCameraAndTurnsAroundThePoint) {
  ViewPose pose;
  pose.position = vec3(1, 2, 3);
  pose.yaw = 0.7f;
  pose.pitch = -0.2f;
  pose.roll = 0.1f;
  const ViewPose around = OrbitAround(pose, 0.8f, 0.3f, 1.5f, 4.0f);
  EXPECT_EQ(around.position, pose.position);
  EXPECT_EQ(around.Forward(), pose.Forward());
  EXPECT_FLOAT_EQ(around.distance, 4);
  // 0.3 of the width right of the middle, 0.2 of the height above it, at depth 4.
  const float half = std::tan(pose.yfov / 2) * 4;
  const vec3 offset = around.Focus() - pose.position;
  EXPECT_NEAR(dot(offset, pose.Forward()), 4, 1e-5);
  EXPECT_NEAR(dot(offset, pose.Right()), 0.6f * half * 1.5f, 1e-5);
  EXPECT_NEAR(dot(offset, pose.Up()), 0.4f * half, 1e-5);
  for (const ViewPose& moved : {Orbit(around, 0.5f, 0.2f), Dolly(around, 3), Dolly(around, -2)}) {
    EXPECT_LT(glm::length(moved.Focus() - around.Focus()), 1e-5f);
    // The point stays where it is in the picture.
    EXPECT_NEAR(moved.aside.x / moved.distance, around.aside.x / around.distance, 1e-6);
    EXPECT_NEAR(moved.aside.y / moved.distance, around.aside.y / around.distance, 1e-6);
  }
  EXPECT_EQ(OrbitAround(pose, 0.5f, 0.5f, 1, 0), pose);
  EXPECT_EQ(OrbitAround(pose, 0.5f, 0.5f, 1, INFINITY), pose);
}

TEST(ViewPose, FocusOnNothingChangesNothing) {
  EXPECT_EQ(FocusOn(SomePose(), 0.5f, 0.5f, 1, 0), SomePose());
  EXPECT_EQ(FocusOn(SomePose(), 0.5f, 0.5f, 1, INFINITY), SomePose());
  EXPECT_EQ(FocusOn(SomePose(), 0.5f, 0.5f, 1, NAN), SomePose());
}

TEST(ViewPose, BetweenTakesTheShortWayAround) {
  ViewPose a;
  a.yaw = 3.0f;
  ViewPose b = a;
  b.yaw = -3.0f;
  EXPECT_GT(std::abs(Between(a, b, 0.5f).yaw), 3.0f);
  EXPECT_EQ(Between(a, b, 1), b);
  EXPECT_NEAR(Between(a, b, 0).yaw, a.yaw, 1e-6f);
}

TEST(ViewPose, FilePoseSeesWhatTheFileSees) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  const Aabb bounds = SceneBounds(scene, 0);
  const ViewPose pose = FilePose(scene, bounds, 0, 0);
  const mat4 world = NodeTransforms(scene, 0)[static_cast<size_t>(scene.cameras[0].node)];
  ExpectNear(pose.position, vec3(world[3]));
  ExpectNear(pose.Forward(), -glm::normalize(vec3(world[2])), 1e-4f);
  EXPECT_FLOAT_EQ(pose.yfov, scene.cameras[0].yfov);
  EXPECT_GT(pose.distance, 0.1f);
}

// Rays from beyond 1e18 cannot be traced: no number of turns of the mouse wheel leads there.
TEST(ViewPose, NoMovementLeavesTheReachOfRays) {
  ViewPose dollied = SomePose();
  ViewPose flown = SomePose();
  for (int i = 0; i < 500; ++i) {
    dollied = Dolly(dollied, -1);
    flown = Fly(Dolly(flown, -1), 0.3f * flown.distance, 0, -flown.distance);
    flown = Orbit(Pan(flown, 300, -200, 10), 0.1f, 0.2f);
  }
  for (const ViewPose& pose : {dollied, flown, Dolly(SomePose(), -1e6f), Dolly(SomePose(), 1e6f)}) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_LE(std::abs(pose.position[c]), 1e18f);
    }
    EXPECT_GT(pose.distance, 0);
    EXPECT_LE(pose.distance, 1e18f);
  }
  // The way back leads to the scene.
  for (int i = 0; i < 500; ++i) {
    dollied = Dolly(dollied, 1);
  }
  EXPECT_LT(dollied.distance, 1.0f);
}

}  // namespace
}  // namespace stillray::view::view_pose_test
