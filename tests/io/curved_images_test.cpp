// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Images in balls against points of the ball that reflect a known point to the eye, found in double
// precision.
#include "io/curved_images.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/pixels.h"
#include "mirror_room.h"

namespace stillray::io::curved_images_test {
namespace {

constexpr double kRadius = 0.6;

void SetCurved(Frame* frame) {
  CameraFits fits(frame->guides);
  FrameImages images;
  SetCurvedImages(&fits, false, frame, &images);
}

RoomCamera Now() {
  RoomCamera camera;
  camera.position = {0.1, 1.5, -4.0};
  camera.pan = 0.05;
  return camera;
}

RoomCamera Before() {
  RoomCamera camera = Now();
  camera.position += glm::dvec3(-0.3, 0.05, -0.1);
  camera.pan = 0.02;
  return camera;
}

Room RoomWithBall(RoomSurface surface = RoomSurface::kRough) {
  Room room = EmptyRoom();
  room.balls.push_back({{0.2, 1.0, -0.5}, kRadius, surface});
  return room;
}

RoomPicture Picture(const Room& room, const RoomCamera& before = Before()) {
  RoomOptions options;
  options.width = 320;
  options.height = 240;
  options.halves = false;
  return Trace(room, Now(), before, options);
}

bool IsBall(const RoomPicture& picture, int x, int y) {
  return picture.what(x, y) == static_cast<uint32_t>(RoomSurface::kRough) + 1;
}

/// Motion of the reflection of what the ball shows at this pixel, `distance` away from it: the
/// point of the ball where the angles to the eye before and to that point are the same.
vec2 ReflectedMotion(const Room& room, const RoomPicture& picture, double distance, int x, int y) {
  const RoomBall& ball = room.balls.back();
  const glm::dvec2 p = PointOfPixel(picture.frame.width, picture.frame.height, x, y);
  const glm::dvec3 ray = Now().Ray(p);
  const glm::dvec3 at =
      Now().position + static_cast<double>(picture.frame.guides.depth(x, y)) * ray;
  glm::dvec3 normal = glm::normalize(at - ball.centre);
  const glm::dvec3 seen = at + distance * glm::reflect(glm::normalize(ray), normal);
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 point = ball.centre + ball.radius * normal;
    normal =
        glm::normalize(glm::normalize(Before().position - point) + glm::normalize(seen - point));
  }
  const glm::dvec3 point = ball.centre + ball.radius * normal;
  return vec2((Before().Project(point) - p) * (0.5 * picture.frame.width));
}

/// Root mean squares over the middle of the ball of the motion's error, with the image's motion and
/// with that of the surface.
struct Errors {
  double image = 0;
  double surface = 0;
  int count = 0;
};

Errors ErrorsOf(const Room& room, const RoomPicture& picture, double distance) {
  Errors errors;
  const Guides& g = picture.frame.guides;
  for (int y = 0; y < picture.frame.height; ++y) {
    for (int x = 0; x < picture.frame.width; ++x) {
      const glm::dvec3 normal(VectorAt(g.normal, x, y));
      const glm::dvec3 ray =
          glm::normalize(Now().Ray(PointOfPixel(picture.frame.width, picture.frame.height, x, y)));
      if (!IsBall(picture, x, y) || -glm::dot(normal, ray) < 0.6) {
        continue;
      }
      const vec2 expected = ReflectedMotion(room, picture, distance, x, y);
      const auto squared = [&](const Image2& motion) {
        return std::pow(static_cast<double>(motion[0](x, y) - expected.x), 2) +
               std::pow(static_cast<double>(motion[1](x, y) - expected.y), 2);
      };
      errors.image += squared(picture.frame.reflection.motion);
      errors.surface += squared(g.motion);
      ++errors.count;
    }
  }
  errors.image = std::sqrt(errors.image / errors.count);
  errors.surface = std::sqrt(errors.surface / errors.count);
  return errors;
}

int Shown(const RoomPicture& picture) {
  int count = 0;
  for (int y = 0; y < picture.frame.height; ++y) {
    for (int x = 0; x < picture.frame.width; ++x) {
      count += picture.frame.reflection.depth(x, y) > 0 ? 1 : 0;
    }
  }
  return count;
}

TEST(SetCurvedImages, ReflectionsInABallMoveAsTheReflectedPointsDo) {
  const Room room = RoomWithBall();
  RoomPicture picture = Picture(room);
  SetCurved(&picture.frame);
  for (const double distance : {1.5, 3.0, 100.0}) {
    const Errors errors = ErrorsOf(room, picture, distance);
    EXPECT_GT(errors.count, 1000);
    EXPECT_GT(errors.surface, 0.8);
    EXPECT_LT(errors.image, 0.35 * errors.surface) << distance;
  }
}

// In the middle of the ball the mirror equation is exact: 1 / i = 2 / r + 1 / d.
TEST(SetCurvedImages, DepthFollowsFromTheMirrorEquation) {
  Room room = EmptyRoom();
  room.balls.push_back({{0.1, 1.5, 0.0}, kRadius, RoomSurface::kRough});
  RoomOptions options;
  options.halves = false;
  RoomCamera camera = Now();
  camera.pan = 0;
  RoomPicture picture = Trace(room, camera, camera, options);
  SetCurved(&picture.frame);
  const double distance = 4.0 - kRadius;
  EXPECT_NEAR(picture.frame.reflection.depth(80, 60), distance + 1 / (2 / kRadius + 1 / distance),
              0.01);
}

TEST(SetCurvedImages, OnlyConvexSurfacesHaveThem) {
  RoomPicture picture = Picture(RoomWithBall());
  SetCurved(&picture.frame);
  int on_ball = 0;
  for (int y = 0; y < picture.frame.height; ++y) {
    for (int x = 0; x < picture.frame.width; ++x) {
      const bool ball = IsBall(picture, x, y);
      on_ball += ball ? 1 : 0;
      if (!ball) {
        ASSERT_EQ(picture.frame.reflection.depth(x, y), 0) << x << " " << y;
      }
      EXPECT_EQ(picture.frame.guides.roughness(x, y),
                picture.frame.reflection.depth(x, y) > 0 ? kCurvedRoughness : 1.0f);
    }
  }
  EXPECT_GT(Shown(picture), 0.8 * on_ball);
  // Seen from inside, the same ball is concave.
  RoomPicture inside = Picture(RoomWithBall());
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < inside.frame.height; ++y) {
      for (int x = 0; x < inside.frame.width; ++x) {
        if (IsBall(inside, x, y) && c < 2) {
          inside.frame.guides.normal[c](x, y) *= -1;
        }
      }
    }
  }
  SetCurved(&inside.frame);
  EXPECT_LT(Shown(inside), 0.05 * on_ball);
}

TEST(SetCurvedImages, OtherImagesAndRoughnessStay) {
  RoomPicture picture = Picture(RoomWithBall());
  picture.frame.guides.roughness = Image1(320, 240);
  picture.frame.guides.roughness.Fill(0.05f);
  SetCurved(&picture.frame);
  EXPECT_EQ(Shown(picture), 0);  // a smooth ball has other guides than its surface
  EXPECT_EQ(picture.frame.guides.roughness(0, 0), 0.05f);

  picture.frame.guides.roughness.Fill(0.2f);
  picture.frame.reflection.depth.Fill(7);
  SetCurved(&picture.frame);
  EXPECT_EQ(picture.frame.reflection.depth(160, 120), 7);

  RoomPicture unknown = Picture(RoomWithBall());
  unknown.frame.refraction.depth = Image1(320, 240);
  unknown.frame.refraction.depth(5, 6) = 3;
  SetCurved(&unknown.frame);
  EXPECT_EQ(unknown.frame.guides.roughness(5, 6), 0);
}

TEST(SetCurvedImages, ImagesMoveAlongWithTheirSurface) {
  RoomPicture still = Picture(RoomWithBall());
  RoomPicture moving = Picture(RoomWithBall());
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      moving.frame.guides.motion[0](x, y) += IsBall(moving, x, y) ? 2.5f : 0.0f;
    }
  }
  SetCurved(&still.frame);
  SetCurved(&moving.frame);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      if (still.frame.reflection.depth(x, y) > 0) {
        EXPECT_NEAR(moving.frame.reflection.motion[0](x, y),
                    still.frame.reflection.motion[0](x, y) + 2.5f, 0.02f);
      }
    }
  }
}

TEST(SetCurvedImages, WithoutAKnownCameraThereAreNone) {
  RoomPicture picture = Picture(RoomWithBall());
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      picture.frame.guides.motion[0](x, y) = static_cast<float>((x * 7 + y * 13) % 31);
    }
  }
  SetCurved(&picture.frame);
  EXPECT_EQ(Shown(picture), 0);
  EXPECT_EQ(picture.frame.guides.roughness(160, 120), 1);
  picture.frame.guides.motion = Image2();
  SetCurved(&picture.frame);
  EXPECT_EQ(Shown(picture), 0);
}

TEST(HasCurvedImages, NeedsAConvexSurface) {
  EXPECT_TRUE(HasCurvedImages(Picture(RoomWithBall()).frame.guides));
  EXPECT_FALSE(HasCurvedImages(Picture(EmptyRoom()).frame.guides));
  EXPECT_FALSE(HasCurvedImages(Trace(RoomWithMirror(), Now(), Before()).frame.guides));
}

}  // namespace
}  // namespace stillray::io::curved_images_test
