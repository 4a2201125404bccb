// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Reflections from hit distances, against points reflected at a plane in double precision.
#include "stillray/reflections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/vec.h"

namespace stillray::reflections_test {
namespace {

using glm::dmat3;
using glm::dvec2;
using glm::dvec3;
using ::testing::HasSubstr;

constexpr int kWidth = 640;
constexpr int kHeight = 360;
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A pinhole camera with x to the right, y up and z forward, where nothing turns it.
struct Pinhole {
  dvec3 position{0.0};
  double pan = 0;  ///< radians, to the right
  double tilt = 0;
  dvec2 tangent{0.7, 0.7 * kHeight / kWidth};  ///< of half the angles of view
  dvec2 shift{0.0};                            ///< of the centre of projection, in half pictures

  dmat3 Axes() const {  // columns: right, up, forward
    const dvec3 right(std::cos(pan), 0, -std::sin(pan));
    const dvec3 level(std::sin(pan), 0, std::cos(pan));
    return dmat3(right, dvec3(0, std::cos(tilt), 0) - std::sin(tilt) * level,
                 std::cos(tilt) * level + dvec3(0, std::sin(tilt), 0));
  }
  /// Of unit depth.
  dvec3 Ray(dvec2 pixel) const {
    const dvec2 p = pixel / dvec2(kWidth, kHeight) * 2.0 - 1.0 - shift;
    return Axes() * dvec3(p.x * tangent.x, -p.y * tangent.y, 1);
  }
  dvec3 InCamera(dvec3 point) const { return glm::transpose(Axes()) * (point - position); }
  dvec2 Pixel(dvec3 point) const {
    const dvec3 v = InCamera(point);
    const dvec2 p = dvec2(v.x, -v.y) / (v.z * tangent) + shift;
    return (p + 1.0) * 0.5 * dvec2(kWidth, kHeight);
  }
};

/// Conventions of clip space.
struct Clip {
  double forward = -1;  ///< z of camera space in front of the camera
  double y = 1;         ///< -1: y down, as Vulkan has it
};

/// Row by row.
CameraMatrices MatricesFor(const Pinhole& camera, const Clip& clip) {
  const dmat3 axes = camera.Axes();
  std::array<double, 16> to_camera{};
  for (size_t row = 0; row < 3; ++row) {
    const dvec3 axis = axes[static_cast<int>(row)] * (row == 2 ? clip.forward : 1.0);
    for (size_t i = 0; i < 3; ++i) {
      to_camera[4 * row + i] = axis[static_cast<int>(i)];
    }
    to_camera[4 * row + 3] = -glm::dot(axis, camera.position);
  }
  to_camera[15] = 1;
  const double f = clip.forward;
  const std::array<double, 16> projection = {1 / camera.tangent.x,
                                             0,
                                             f * camera.shift.x,
                                             0,
                                             0,
                                             clip.y / camera.tangent.y,
                                             -f * clip.y * camera.shift.y,
                                             0,
                                             0,
                                             0,
                                             1.002 * f,
                                             -0.2,
                                             0,
                                             0,
                                             f,
                                             0};
  return MatricesOf(to_camera, projection);
}

/// A mirror in space: dot(normal, point) = offset.
constexpr double kOffset = 4;
dvec3 MirrorNormal() {
  return glm::normalize(dvec3(-0.3, 0.2, 1));
}

struct MirrorPicture {
  Guides guides;
  Image1 hits;
  Image1 image_depth;
  std::array<Plane<double>, 2> motion = {Plane<double>(kWidth, kHeight),
                                         Plane<double>(kWidth, kHeight)};
};

/// What a mirror that fills the picture shows: a different distance in every pixel.
MirrorPicture Trace(const Pinhole& now, const Pinhole& before) {
  MirrorPicture picture;
  picture.guides.depth = picture.hits = picture.image_depth = Image1(kWidth, kHeight);
  const dvec3 n = MirrorNormal();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const dvec2 pixel(x + 0.5, y + 0.5);
      const dvec3 ray = now.Ray(pixel);
      const double z = (kOffset - glm::dot(n, now.position)) / glm::dot(n, ray);
      const dvec3 on_mirror = now.position + z * ray;
      const dvec3 reflected = glm::normalize(ray - 2.0 * glm::dot(n, ray) * n);
      const auto hit = static_cast<float>(0.5 + ((x * 7 + y * 13) % 50) * 0.3);
      const dvec3 seen = on_mirror + static_cast<double>(hit) * reflected;
      const dvec3 image = seen - 2.0 * (glm::dot(n, seen) - kOffset) * n;
      picture.guides.depth(x, y) = static_cast<float>(z);
      picture.hits(x, y) = hit;
      picture.image_depth(x, y) = static_cast<float>(now.InCamera(image).z);
      const dvec2 motion = before.Pixel(image) - pixel;
      picture.motion[0](x, y) = motion.x;
      picture.motion[1](x, y) = motion.y;
    }
  }
  picture.guides.roughness = Image1(kWidth, kHeight);
  return picture;
}

Pinhole Now() {
  Pinhole camera;
  camera.position = {0.3, 0.1, -0.5};
  camera.pan = 0.1;
  camera.tilt = -0.05;
  camera.shift = {0.1, -0.06};
  return camera;
}

Pinhole Before() {
  Pinhole camera = Now();
  camera.position += dvec3(-0.12, 0.05, -0.2);
  camera.pan = 0.07;
  camera.tilt = -0.06;
  camera.tangent *= 1.01;
  return camera;
}

struct Errors {
  double depth = 0;   ///< relative
  double motion = 0;  ///< pixels
  double moved = 0;   ///< the longest motion
};

Errors ErrorsOf(const VirtualGuides& found, const MirrorPicture& picture) {
  Errors errors;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double depth = picture.image_depth(x, y);
      const dvec2 motion = {picture.motion[0](x, y), picture.motion[1](x, y)};
      const dvec2 given = {found.motion[0](x, y), found.motion[1](x, y)};
      errors.depth = std::max(errors.depth, std::abs(found.depth(x, y) / depth - 1));
      errors.motion = std::max(errors.motion, glm::length(given - motion));
      errors.moved = std::max(errors.moved, glm::length(motion));
    }
  }
  return errors;
}

TEST(ReflectionsFromHits, AreThoseOfPointsReflectedAtThePlane) {
  const MirrorPicture picture = Trace(Now(), Before());
  for (const Clip& clip : {Clip{-1, 1}, Clip{-1, -1}, Clip{1, 1}, Clip{1, -1}}) {
    SCOPED_TRACE(clip.forward);
    SCOPED_TRACE(clip.y);
    const Result<VirtualGuides> found = ReflectionsFromHits(
        picture.guides, picture.hits, MatricesFor(Now(), clip), MatricesFor(Before(), clip));
    ASSERT_TRUE(found.ok()) << found.status().message();
    const Errors errors = ErrorsOf(*found, picture);
    EXPECT_LT(errors.depth, 1e-6);
    EXPECT_LT(errors.motion, 1e-3);
    EXPECT_GT(errors.moved, 10);
    EXPECT_TRUE(found->normal.empty() && found->albedo.empty() && found->id.empty());
  }
}

TEST(ReflectionsFromHits, StandStillInFrontOfACameraThatStands) {
  const MirrorPicture picture = Trace(Now(), Now());
  const Result<VirtualGuides> found = ReflectionsFromHits(
      picture.guides, picture.hits, MatricesFor(Now(), Clip()), MatricesFor(Now(), Clip()));
  ASSERT_TRUE(found.ok());
  EXPECT_LT(ErrorsOf(*found, picture).motion, 1e-4);
}

TEST(ReflectionsFromHits, TheSkyMovesAsTheCameraTurns) {
  MirrorPicture picture = Trace(Now(), Before());
  picture.hits.Fill(kInf);
  picture.hits(11, 22) = 1e9f;
  Pinhole near = Before();
  near.position = Now().position;
  const Result<VirtualGuides> found = ReflectionsFromHits(
      picture.guides, picture.hits, MatricesFor(Now(), Clip()), MatricesFor(Before(), Clip()));
  ASSERT_TRUE(found.ok());
  for (const ivec2& p : {ivec2(11, 22), ivec2(600, 300)}) {
    const dvec2 pixel(p.x + 0.5, p.y + 0.5);
    const dvec2 expected = near.Pixel(near.position + Now().Ray(pixel)) - pixel;
    EXPECT_EQ(found->depth(p.x, p.y), kInf);
    EXPECT_NEAR(found->motion[0](p.x, p.y), expected.x, 1e-3);
    EXPECT_NEAR(found->motion[1](p.x, p.y), expected.y, 1e-3);
  }
}

TEST(ReflectionsFromHits, PixelsWithoutAHitOrASurfaceShowNone) {
  MirrorPicture picture = Trace(Now(), Before());
  picture.hits(1, 0) = 0;
  picture.hits(2, 0) = -3;
  picture.hits(3, 0) = kNan;
  picture.hits(4, 0) = -kInf;
  picture.guides.depth(5, 0) = kInf;
  picture.guides.depth(6, 0) = 0;
  picture.guides.depth(7, 0) = kNan;
  picture.guides.depth(8, 0) = -1;
  const Result<VirtualGuides> found = ReflectionsFromHits(
      picture.guides, picture.hits, MatricesFor(Now(), Clip()), MatricesFor(Before(), Clip()));
  ASSERT_TRUE(found.ok());
  EXPECT_GT(found->depth(0, 0), 0);
  for (int x = 1; x < 9; ++x) {
    EXPECT_EQ(found->depth(x, 0), 0) << x;
    EXPECT_EQ(found->motion[0](x, 0), 0) << x;
  }
  EXPECT_GT(found->depth(9, 0), 0);
}

TEST(ReflectionsFromHits, WhatWasBehindTheCameraHasNoHistory) {
  const MirrorPicture picture = Trace(Now(), Before());
  Pinhole turned = Now();
  turned.pan += 3.1;
  const Result<VirtualGuides> found = ReflectionsFromHits(
      picture.guides, picture.hits, MatricesFor(Now(), Clip()), MatricesFor(turned, Clip()));
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->motion[0](320, 180), 2 * kWidth);
  EXPECT_EQ(found->motion[1](320, 180), 2 * kHeight);
}

/// Turned by a right angle, no point of the middle of the picture has w = 1.
TEST(ReflectionsFromHits, ACameraMayTurnFar) {
  for (const double angle : {0.8, 1.2, 1.5708}) {
    Pinhole turned = Now();
    turned.pan += angle;
    const MirrorPicture picture = Trace(Now(), turned);
    const Result<VirtualGuides> found = ReflectionsFromHits(
        picture.guides, picture.hits, MatricesFor(Now(), Clip()), MatricesFor(turned, Clip()));
    ASSERT_TRUE(found.ok());
    int seen = 0;
    for (int x = 0; x < kWidth; ++x) {
      const dvec2 motion(picture.motion[0](x, 100), picture.motion[1](x, 100));
      const dvec2 given(found->motion[0](x, 100), found->motion[1](x, 100));
      if (glm::length(motion) < 1500 && given.x < 2 * kWidth) {
        EXPECT_LT(glm::length(given - motion), 0.02) << x;
        ++seen;
      }
    }
    EXPECT_GT(seen, 100) << angle;
  }
}

/// Without roughness, neighbours tell mirrors from rough surfaces.
TEST(ReflectionsFromHits, WithoutRoughnessNeighboursMustAgree) {
  MirrorPicture picture = Trace(Now(), Before());
  picture.guides.roughness = Image1();
  picture.guides.normal = Image3(kWidth, kHeight);
  picture.guides.normal[2].Fill(-1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      picture.hits(x, y) = 5;  // a mirror to the left
    }
  }
  const CameraMatrices now = MatricesFor(Now(), Clip());
  const Result<VirtualGuides> found =
      ReflectionsFromHits(picture.guides, picture.hits, now, MatricesFor(Before(), Clip()));
  ASSERT_TRUE(found.ok());
  int smooth = 0;
  int rough = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      (x < kWidth / 2 ? smooth : rough) += found->depth(x, y) > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(smooth, 0.99 * kWidth / 2 * kHeight);
  EXPECT_LT(rough, 0.02 * kWidth / 2 * kHeight);
}

TEST(ReflectionsFromHits, SayWhatIsWrong) {
  const MirrorPicture picture = Trace(Now(), Before());
  const CameraMatrices camera = MatricesFor(Now(), Clip());
  const auto message = [&](const Guides& guides, const Image1& hits, const CameraMatrices& now,
                           const CameraMatrices& before) {
    return ReflectionsFromHits(guides, hits, now, before).status().message();
  };
  EXPECT_EQ(message(picture.guides, Image1(3, 4), camera, camera),
            "image 'hit_distance' is 3x4, expected 640x360 as 'depth'");
  EXPECT_EQ(message(Guides(), picture.hits, camera, camera), "image 'depth' is not given");
  Guides guides = picture.guides;
  guides.roughness = Image1(5, 6);
  EXPECT_EQ(message(guides, picture.hits, camera, camera),
            "image 'roughness' is 5x6, expected 640x360 as 'depth'");
  CameraMatrices parallel = camera;
  for (size_t i = 0; i < 4; ++i) {
    parallel.world_to_ndc[4 * i + 3] = i == 3 ? 1 : 0;
  }
  EXPECT_THAT(message(picture.guides, picture.hits, parallel, camera),
              HasSubstr("the camera of this frame has no inverse or no perspective"));
  EXPECT_THAT(message(picture.guides, picture.hits, camera, CameraMatrices()),
              HasSubstr("the camera of the previous frame has no inverse"));
}

}  // namespace
}  // namespace stillray::reflections_test
