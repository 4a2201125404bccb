// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Cameras that are not in the scene.
#include <cmath>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>

#include "test_scenes.h"

namespace stillray::render::free_camera_test {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr float kYfov = 0.9f;

// A wall at z = -5 that fills the view.
SceneBuilder Wall() {
  SceneBuilder builder;
  builder.Add(Quad(vec3(-40, -40, -5), vec3(80, 0, 0), vec3(0, 80, 0)), Lambert(vec3(0.5f)));
  builder.scene.environment.radiance = vec3(1.0f);
  return builder;
}

CameraPose PoseAt(vec3 position) {
  return {glm::translate(mat4(1.0f), position), kYfov};
}

Frame RenderWith(const SceneBuilder& builder, const RenderMoment& moment) {
  return RenderOne(builder.scene, SmallSettings(kWidth, kHeight, 1), moment);
}

TEST(FreeCameraTest, ReplacesTheCameraOfTheScene) {
  SceneBuilder builder = Wall();
  builder.CameraTransform() = At(vec3(1, 2, 3));
  RenderMoment moment;
  moment.pose = PoseAt(vec3(0, 0, -1));
  const Frame frame = RenderWith(builder, moment);
  EXPECT_NEAR(frame.guides.depth(10, 10), 4.0f, 1e-5f);
  EXPECT_EQ(frame.guides.motion[0](10, 10), 0.0f);
  EXPECT_EQ(frame.guides.motion[1](10, 10), 0.0f);
  // The same pose in the scene: the same bits.
  builder.CameraTransform() = At(vec3(0, 0, -1));
  builder.scene.cameras[0].yfov = kYfov;
  const Frame own = RenderWith(builder, {});
  EXPECT_EQ(own.guides.depth(10, 10), frame.guides.depth(10, 10));
  EXPECT_EQ(own.signals[0].radiance[0](5, 7), frame.signals[0].radiance[0](5, 7));
}

TEST(FreeCameraTest, TranslationGivesKnownMotion) {
  const SceneBuilder builder = Wall();
  RenderMoment moment;
  moment.pose = PoseAt(vec3(0.3f, -0.2f, 1.0f));
  moment.previous_pose = PoseAt(vec3(0.0f, 0.1f, 1.0f));
  const Frame frame = RenderWith(builder, moment);
  // A camera that moves right by 0.3 at distance 6 sees the wall move left; then it was further
  // right, by 0.3 focal lengths over 6. Up likewise, with y down.
  const float focal = 0.5f * kHeight / std::tan(0.5f * kYfov);
  for (const int x : {0, 31, 63}) {
    for (const int y : {0, 20, 47}) {
      EXPECT_NEAR(frame.guides.motion[0](x, y), 0.3f * focal / 6.0f, 1e-4f);
      EXPECT_NEAR(frame.guides.motion[1](x, y), 0.3f * focal / 6.0f, 1e-4f);
    }
  }
}

TEST(FreeCameraTest, ZoomAndTurnGiveKnownMotion) {
  const SceneBuilder builder = Wall();
  RenderMoment moment;
  moment.pose = PoseAt(vec3(0.0f));
  moment.previous_pose = moment.pose;
  moment.previous_pose->yfov = 0.6f;
  const float ratio = std::tan(0.5f * kYfov) / std::tan(0.5f * 0.6f);
  const Frame zoom = RenderWith(builder, moment);
  EXPECT_NEAR(zoom.guides.motion[0](50, 30), (50.5f - 32.0f) * (ratio - 1.0f), 1e-3f);
  EXPECT_NEAR(zoom.guides.motion[1](50, 30), (30.5f - 24.0f) * (ratio - 1.0f), 1e-3f);
  // A camera turned to the left by an angle: the centre of the view was on its left side.
  constexpr float kAngle = 0.1f;
  moment.previous_pose = PoseAt(vec3(0.0f));
  moment.pose->world_from_camera = glm::rotate(mat4(1.0f), kAngle, vec3(0, 1, 0));
  const Frame turn = RenderWith(builder, moment);
  const float focal = 0.5f * kHeight / std::tan(0.5f * kYfov);
  const float angle = std::atan(0.5f / focal);  // of pixel 32's centre to the right of the middle
  EXPECT_NEAR(turn.guides.motion[0](32, 24), focal * std::tan(angle - kAngle) - 0.5f, 1e-3f);
}

TEST(FreeCameraTest, TheReferenceSeesTheSame) {
  SceneBuilder builder = Wall();
  builder.Add(Quad(vec3(-1, -1, -4), vec3(1, 0, 0), vec3(0, 2, 0)), Emitter(vec3(2.0f)));
  RenderMoment moment;
  moment.pose = PoseAt(vec3(1.5f, 0, 0));
  const RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  auto renderer = Renderer::Create(builder.scene, settings);
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  Image3 reference;
  ASSERT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
  ASSERT_TRUE((*renderer)->RenderReference(moment, 1, &reference).ok());
  int lit = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool lamp = frame.emission[0](x, y) > 0;
      lit += lamp;
      EXPECT_EQ(lamp, reference[0](x, y) == 2.0f) << x << ' ' << y;
    }
  }
  EXPECT_GT(lit, 20);
}

TEST(FreeCameraTest, ASceneNeedsNoCamera) {
  SceneBuilder builder = Wall();
  builder.scene.cameras.clear();
  RenderMoment moment;
  moment.pose = PoseAt(vec3(0.0f));
  EXPECT_NEAR(RenderWith(builder, moment).guides.depth(3, 3), 5.0f, 1e-5f);
}

TEST(FreeCameraTest, InvalidPosesAreNamed) {
  const SceneBuilder builder = Wall();
  auto renderer = Renderer::Create(builder.scene, SmallSettings(4, 4, 1));
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  const auto message = [&](auto change) {
    RenderMoment moment;
    moment.pose = PoseAt(vec3(0.0f));
    moment.previous_pose = moment.pose;
    change(&moment);
    const Status status = (*renderer)->RenderFrame(moment, &frame);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message();
  };
  EXPECT_THAT(message([](RenderMoment* m) { m->pose->yfov = 0.0f; }),
              HasSubstr("pose: yfov is 0, expected above 0 and below pi"));
  EXPECT_THAT(message([](RenderMoment* m) { m->previous_pose->yfov = 4.0f; }),
              HasSubstr("previous_pose: yfov is 4"));
  EXPECT_THAT(message([](RenderMoment* m) {
                m->pose->world_from_camera[3][1] = std::numeric_limits<float>::quiet_NaN();
              }),
              HasSubstr("nan in column 3, row 1"));
  // Embree ends the program at origins beyond 1.84e18.
  EXPECT_THAT(message([](RenderMoment* m) { m->pose->world_from_camera[3][2] = 2e18f; }),
              HasSubstr("column 3, row 2, expected finite numbers up to 1e+18"));
  EXPECT_THAT(message([](RenderMoment* m) { m->pose.reset(); }),
              HasSubstr("previous_pose is given without pose"));
}

TEST(FreeCameraTest, ACameraAtTheLimitSeesNothing) {
  const SceneBuilder builder = Wall();
  RenderMoment moment;
  moment.pose = PoseAt(vec3(-1e18f, 1e18f, 1e18f));
  EXPECT_TRUE(std::isinf(RenderWith(builder, moment).guides.depth(3, 3)));
}

// The keys of a node are bounded where a file is read, products with the nodes above are not.
TEST(FreeCameraTest, AnimationThatTakesACameraOutOfReachIsRefusedAtThatFrame) {
  SceneBuilder builder = Wall();
  Scene& scene = builder.scene;
  const int parent = static_cast<int>(scene.nodes.size());
  Node scaled;
  scaled.local.scale = vec3(2.0f);
  scene.nodes.push_back(scaled);
  Node child;
  child.name = "rig";
  child.parent = parent;
  scene.nodes.push_back(child);
  scene.cameras[0].node = parent + 1;
  AnimationChannel flight;
  flight.node = parent + 1;
  flight.times = {0.0f, 1.0f};
  flight.values = {vec4(0.0f), vec4(0.0f, 0.0f, 1e18f, 0.0f)};
  scene.animation.push_back(flight);
  auto renderer = Renderer::Create(scene, SmallSettings(4, 4, 1));
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  RenderMoment moment;
  moment.seconds = 0.25;
  EXPECT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
  moment.seconds = 0.95;
  const Status status = (*renderer)->RenderFrame(moment, &frame);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("(\"rig\"): at 0.95 s"));
  EXPECT_THAT(status.message(), HasSubstr("beyond 1e+18"));
}

}  // namespace
}  // namespace stillray::render::free_camera_test
