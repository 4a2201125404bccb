// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Motion from cameras against figures worked by hand. Pictures have 200 x 100 pixels and the
// cameras a focal length of 100 pixels.
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/aov.h"

namespace stillray::aov_cameras_test {
namespace {

using Rows = std::array<double, 16>;

Rows Product(const Rows& a, const Rows& b) {
  Rows product{};
  for (size_t i = 0; i < 4; ++i) {
    for (size_t j = 0; j < 4; ++j) {
      for (size_t k = 0; k < 4; ++k) {
        product[4 * i + j] += a[4 * i + k] * b[4 * k + j];
      }
    }
  }
  return product;
}

constexpr Rows kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
/// As the standard has it: looks along +z; u = 1/2 + x / (2 z), v = 1/2 - y / z.
constexpr Rows kStandard = {0.5, 0, 0, 0, 0, -1, 0, 0, 0.5, 0.5, 1, 1, 0, 0, 0, 0};
/// -1 to 1, y up: u = x / z, v = 2 y / z.
constexpr Rows kSigned = {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0};
/// Looks along -z.
constexpr Rows kBackward = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};

struct Kind {
  const char* name;
  Rows turn;        ///< after the standard's camera space
  Rows projection;  ///< from the turned camera space
};
const Kind kKinds[] = {
    {"standard", kIdentity, kStandard},
    {"signed", kIdentity, kSigned},
    {"backward", kBackward, Product(kBackward, kStandard)},
    {"signed and backward", kBackward, Product(kBackward, kSigned)},
};

/// A camera at (x, y, z) that looks along +z, turned to the right by an angle.
CameraMatrices CameraAt(const Kind& kind, double x, double y, double z, double angle = 0) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const Rows move = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1};
  // Points to the right (x = sin, z = cos) move to the middle.
  const Rows turn = {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, 0, 0, 0, 1};
  const Rows camera = Product(Product(move, turn), kind.turn);
  return {camera, Product(camera, kind.projection)};
}

class AovCameras : public ::testing::TestWithParam<Kind> {
 protected:
  /// Motion of a plane at this depth.
  static Image2 Motion(double depth, const CameraMatrices& now, const CameraMatrices& before) {
    Image1 plane(200, 100);
    plane.Fill(static_cast<float>(depth));
    return MotionFromCameras(plane, now, before);
  }
};

TEST_P(AovCameras, FocalLength) {
  const CameraMatrices camera = CameraAt(GetParam(), 1, 2, 3, 0.3);
  EXPECT_NEAR(FocalPixels(camera, 200, 100), 100, 1e-9);
  EXPECT_NEAR(CentredFocalPixels(camera, 200, 100), 100, 1e-9);
  EXPECT_EQ(CentredFocalPixels(camera, 230, 100), 0) << "pixels that are not square";
}

TEST(FocalPixels, IsZeroWithoutPerspective) {
  constexpr Rows kParallel = {0.5, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0.1, 0, 0.5, 0.5, 0, 1};
  EXPECT_EQ(FocalPixels({kIdentity, kParallel}, 200, 100), 0);
  EXPECT_EQ(CentredFocalPixels({kIdentity, kParallel}, 200, 100), 0);
}

TEST(FocalPixels, PositionsNeedAnAxisThroughTheCentre) {
  Rows shifted = kStandard;
  shifted[8] += 0.1 * shifted[11];  // a tenth of the width, as with a shifted lens
  EXPECT_NEAR(FocalPixels({kIdentity, shifted, true}, 200, 100), 100, 1e-9);
  EXPECT_EQ(CentredFocalPixels({kIdentity, shifted, true}, 200, 100), 0);
}

// A camera that went 0.1 to the right has everything go to the left: by 0.1 * 100 / 5 pixels.
TEST_P(AovCameras, Sidewards) {
  const Image2 motion = Motion(5, CameraAt(GetParam(), 0.1, 0, 0), CameraAt(GetParam(), 0, 0, 0));
  EXPECT_NEAR(motion[0](10, 20), 2, 1e-4);
  EXPECT_NEAR(motion[1](10, 20), 0, 1e-4);
  const Image2 far = Motion(10, CameraAt(GetParam(), 0.1, 0, 0), CameraAt(GetParam(), 0, 0, 0));
  EXPECT_NEAR(far[0](150, 80), 1, 1e-4);
}

// One that went up has everything go down, so that it was further up: towards row 0.
TEST_P(AovCameras, Upwards) {
  const Image2 motion = Motion(5, CameraAt(GetParam(), 0, 0.1, 0), CameraAt(GetParam(), 0, 0, 0));
  EXPECT_NEAR(motion[0](10, 20), 0, 1e-4);
  EXPECT_NEAR(motion[1](10, 20), -2, 1e-4);
}

// A point 50 pixels right of the middle at depth 4 was at 40 when the camera was one further away.
TEST_P(AovCameras, Forwards) {
  const Image2 motion = Motion(4, CameraAt(GetParam(), 0, 0, 1), CameraAt(GetParam(), 0, 0, 0));
  EXPECT_NEAR(motion[0](149, 49), -0.2 * 49.5, 1e-4);
  EXPECT_NEAR(motion[1](149, 49), 0.2 * 0.5, 1e-4);
}

// After a turn by 10 degrees, the point in the middle was 100 tan(10 degrees) pixels to the right.
TEST_P(AovCameras, Turned) {
  const double angle = 10 * std::numbers::pi / 180;
  const Image2 motion =
      Motion(7, CameraAt(GetParam(), 0, 0, 0, angle), CameraAt(GetParam(), 0, 0, 0));
  // Half a pixel right of the middle: at the angle 10 degrees + atan(1/200).
  EXPECT_NEAR(motion[0](100, 50), 100 * std::tan(angle + std::atan(0.005)) - 0.5, 1e-3);
  EXPECT_GT(motion[1](100, 99), 0);  // farther points were nearer to the border
}

INSTANTIATE_TEST_SUITE_P(Kinds, AovCameras, ::testing::ValuesIn(kKinds), [](const auto& info) {
  std::string name = info.param.name;
  std::erase(name, ' ');
  return name;
});

TEST(AovCameras, BehindTheOtherCameraAndNothingAtAll) {
  Image1 depth(200, 100);
  depth.Fill(1);
  depth(0, 0) = std::numeric_limits<float>::infinity();
  const Kind& kind = kKinds[0];
  const Image2 motion = MotionFromCameras(depth, CameraAt(kind, 0, 0, 0), CameraAt(kind, 0, 0, 3));
  EXPECT_EQ(motion[0](5, 5), 400);
  EXPECT_EQ(motion[1](5, 5), 200);
  EXPECT_EQ(motion[0](0, 0), 0);
}

/// A file with depth, and cameras as attributes.
ExrImage WithCameras(const std::string& to_camera, const std::string& to_ndc) {
  ExrImage image;
  image.width = image.height = 1;
  for (const char* name : {"R", "G", "B", "Z"}) {
    Image1 plane(1, 1);
    plane.Fill(2);
    image.Add(name, PixelType::kFloat, plane);
  }
  image.other_attributes["worldToCamera"] = to_camera;
  image.other_attributes["worldToNDC"] = to_ndc;
  return image;
}

TEST(AovCameras, AreUsedWhereMotionIsMissing) {
  const std::string identity = fmt::format("{}", fmt::join(kIdentity, " "));
  const std::string standard = fmt::format("{}", fmt::join(kStandard, " "));
  const ExrImage image = WithCameras(identity, standard);
  const Result<AovLayout> layout = UnderstandAovs(image, {"arnold", {}}, "f");
  ASSERT_TRUE(layout.ok()) << layout.status().message();
  EXPECT_TRUE(layout->motion_from_cameras);
  EXPECT_THAT(AovTable(*layout), ::testing::HasSubstr("without the motion of objects"));
  const Result<Frame> frame = ImportFrame(image, *layout, {0, 0}, "f");
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->guides.motion[0](0, 0), 0);
  EXPECT_EQ(CameraOf(image)->world_to_ndc, kStandard);
  EXPECT_EQ(frame->focal_pixels, 0) << "the camera is of pictures twice as wide as high";

  EXPECT_FALSE(UnderstandAovs(image, {"arnold", {"motion=none"}}, "f")->motion_from_cameras);
  EXPECT_FALSE(UnderstandAovs(image, {"arnold", {"depth=none"}}, "f")->motion_from_cameras);
  const Result<Frame> without = ImportFrame(WithCameras(identity, "1 2"), *layout, {0, 0}, "f");
  EXPECT_EQ(without.status().message(),
            "f: has no usable worldToCamera and worldToNDC, which the first frame has");
  const std::string zero = "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0";
  EXPECT_FALSE(CameraOf(WithCameras(zero, standard)).has_value());
  EXPECT_FALSE(CameraOf(WithCameras("x", standard)).has_value());
}

}  // namespace
}  // namespace stillray::aov_cameras_test
