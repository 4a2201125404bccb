// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "stillray/aov.h"

namespace stillray::aov_conventions_test {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

Image1 Constant(int width, int height, float value) {
  Image1 image(width, height);
  image.Fill(value);
  return image;
}

/// Motion (x, y) stored in a picture of 200 x 100 pixels, converted.
std::array<float, 2> Motion(float x, float y, const MotionConvention& convention,
                            const JitterPair& jitter = {}) {
  const Image2 motion =
      ConvertMotion(Constant(200, 100, x), Constant(200, 100, y), convention, jitter);
  return {motion[0](3, 5), motion[1](3, 5)};
}

float Depth(float stored, const DepthConvention& convention) {
  return ConvertDepth(Constant(1, 1, stored), convention)(0, 0);
}

std::array<float, 3> Normal(std::array<float, 3> n, const NormalConvention& convention,
                            const std::array<float, 9>* camera = nullptr) {
  Image3 image(1, 1);
  for (int i = 0; i < 3; ++i) {
    image[i](0, 0) = n[static_cast<size_t>(i)];
  }
  const Image3 unit = ConvertNormal(image, convention, camera);
  return {unit[0](0, 0), unit[1](0, 0), unit[2](0, 0)};
}

using Pair = std::array<float, 2>;
using Triple = std::array<float, 3>;

// A point that moved 3 pixels to the right and 2 down was at (-3, -2) from where it is now.
TEST(AovMotion, OwnConventionStaysAsItIs) {
  EXPECT_EQ(Motion(-3, -2, {}), (Pair{-3, -2}));
}
TEST(AovMotion, BlenderPointsUp) {
  EXPECT_EQ(Motion(-3, 2, {.y_up = true}), (Pair{-3, -2}));
}
TEST(AovMotion, OppositeDirections) {
  EXPECT_EQ(Motion(3, 2, {.direction = MotionDirection::kFromPrevious}), (Pair{-3, -2}));
  EXPECT_EQ(Motion(3, -2, {.direction = MotionDirection::kToNext, .y_up = true}), (Pair{-3, -2}));
}
// The same point goes on by 3 pixels to the right and 2 down.
TEST(AovMotion, TowardsTheNextFrame) {
  const auto next = [](float x, float y, const MotionConvention& convention,
                       const JitterPair& jitter) {
    const Image2 motion =
        ConvertNextMotion(Constant(200, 100, x), Constant(200, 100, y), convention, jitter);
    return Pair{motion[0](3, 5), motion[1](3, 5)};
  };
  const MotionConvention to_next = {.direction = MotionDirection::kToNext};
  EXPECT_EQ(next(3, 2, to_next, {}), (Pair{3, 2}));
  const MotionConvention blender = {.direction = MotionDirection::kFromNext, .y_up = true};
  EXPECT_EQ(next(-3, 2, blender, {}), (Pair{3, 2}));
  EXPECT_EQ(Motion(-3, 2, blender), (Pair{-3, -2}));  // steady motion
  // A still point at 10.25 seen through a sample at +0.25 stands at 10.0 in the grid, and through
  // one at -0.5 in the next frame at 10.75.
  const MotionConvention jittered = {.direction = MotionDirection::kToNext, .jittered = true};
  EXPECT_EQ(next(0.75f, 0, jittered, {0.25f, 0, -0.5f, 0}), (Pair{0, 0}));
}
TEST(AovMotion, FractionsOfThePicture) {
  EXPECT_EQ(Motion(-0.25f, -0.5f, {.unit = MotionUnit::kFraction}), (Pair{-50, -50}));
}
TEST(AovMotion, DeviceCoordinatesSpanTwo) {
  EXPECT_EQ(Motion(-0.25f, 0.5f, {.unit = MotionUnit::kNdc, .y_up = true}), (Pair{-25, -25}));
}
TEST(AovMotion, ScaleUndoesAHalfOpenShutter) {
  EXPECT_EQ(Motion(-1.5f, -1, {.scale = 2}), (Pair{-3, -2}));
}
// A still point at 10.25: seen through a sample at +0.25 it stands at 10.0 in the grid, before at
// -0.5 at 10.75. Stored motion 0.75, true motion 0.
TEST(AovMotion, JitterIsTakenOut) {
  EXPECT_EQ(Motion(0.75f, 0, {.jittered = true}, {0.25f, 0, -0.5f, 0}), (Pair{0, 0}));
  EXPECT_EQ(Motion(0.75f, 0, {}, {0.25f, 0, -0.5f, 0}), (Pair{0.75f, 0}));
}

TEST(AovDepth, BlendersSkyIsInfinite) {
  EXPECT_EQ(Depth(7.5f, {}), 7.5f);
  EXPECT_EQ(Depth(1e10f, {}), kInf);
  EXPECT_EQ(Depth(kInf, {}), kInf);
}
TEST(AovDepth, RaysAreLongerThanDepth) {
  // Pixel (0, 0) of 7 x 9 lies 3 and 4 pixels from the middle: a ray of 13 at focal length 12.
  const Image1 depth = ConvertDepth(Constant(7, 9, 13), {.kind = DepthKind::kRay, .focal = 12});
  EXPECT_FLOAT_EQ(depth(0, 0), 12.0f);
  EXPECT_FLOAT_EQ(depth(3, 4), 13.0f);  // the middle
}
TEST(AovDepth, Inverse) {
  EXPECT_FLOAT_EQ(Depth(0.25f, {.kind = DepthKind::kInverse}), 4.0f);
  EXPECT_EQ(Depth(0, {.kind = DepthKind::kInverse}), kInf);
}
TEST(AovDepth, Normalised) {
  const DepthConvention c = {.kind = DepthKind::kNormalised, .near = 2, .far = 10};
  EXPECT_FLOAT_EQ(Depth(0.25f, c), 4.0f);
  EXPECT_EQ(Depth(1, c), kInf);
}
// near 1, far 100, z = 10: d = (100 / 99) (1 - 1 / 10) = 0.909090...
TEST(AovDepth, Projected) {
  const DepthConvention c = {.kind = DepthKind::kProjected, .near = 1, .far = 100};
  EXPECT_NEAR(Depth(10.0f / 11.0f, c), 10.0f, 1e-4);
  EXPECT_FLOAT_EQ(Depth(0, c), 1.0f);
  EXPECT_EQ(Depth(1, c), kInf);
  EXPECT_FLOAT_EQ(Depth(0.75f, {.kind = DepthKind::kProjected, .near = 1}), 4.0f);
}
TEST(AovDepth, Reversed) {
  const DepthConvention c = {.kind = DepthKind::kReversed, .near = 1, .far = 100};
  EXPECT_NEAR(Depth(1.0f / 11.0f, c), 10.0f, 1e-5);
  EXPECT_FLOAT_EQ(Depth(1, c), 1.0f);
  EXPECT_EQ(Depth(0, c), kInf);
  EXPECT_FLOAT_EQ(Depth(0.25f, {.kind = DepthKind::kReversed, .near = 1}), 4.0f);
}
TEST(AovDepth, NanStays) {
  for (int kind = 0; kind < 6; ++kind) {
    DepthConvention c = {.kind = static_cast<DepthKind>(kind), .near = 1, .far = 2, .focal = 1};
    EXPECT_TRUE(std::isnan(Depth(std::nanf(""), c))) << kind;
  }
}

TEST(AovNormal, BecomeUnit) {
  EXPECT_EQ(Normal({0, 0, 0.5f}, {}), (Triple{0, 0, 1}));
  EXPECT_EQ(Normal({0, 0, 0}, {}), (Triple{0, 0, 0}));
}
TEST(AovNormal, Encoded) {
  EXPECT_EQ(Normal({0.5f, 0, 0.5f}, {.encoded = true}), (Triple{0, -1, 0}));
  EXPECT_EQ(Normal({0.502f, 0.502f, 0.502f}, {.encoded = true}), (Triple{0, 0, 0}));
}
// y up in the file, z up here: ours (x, y, z) is the file's (x, -z, y).
TEST(AovNormal, AxesChangePlaces) {
  EXPECT_EQ(Normal({0, 1, 0}, {.axes = {1, -3, 2}}), (Triple{0, 0, 1}));
  EXPECT_EQ(Normal({0, 0, 1}, {.axes = {1, -3, 2}}), (Triple{0, -1, 0}));
}
// A camera turned by 90 degrees: world x is seen along camera y, world y along camera -x.
TEST(AovNormal, CameraSpaceIsTurnedBack) {
  const std::array<float, 9> camera = {0, 1, 0, -1, 0, 0, 0, 0, 1};
  EXPECT_EQ(Normal({0, 1, 0}, {.camera_space = true}, &camera), (Triple{1, 0, 0}));
  EXPECT_EQ(Normal({-1, 0, 0}, {.camera_space = true}, &camera), (Triple{0, 1, 0}));
  EXPECT_EQ(Normal({0, 1, 0}, {.camera_space = true}, nullptr), (Triple{0, 1, 0}));
  EXPECT_EQ(Normal({0, 1, 0}, {}, &camera), (Triple{0, 1, 0}));
}

}  // namespace
}  // namespace stillray::aov_conventions_test
