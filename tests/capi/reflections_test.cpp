// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Reflections from hit distances in C: those of the C++ function.
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include <gmock/gmock.h>

#include "stillray/reflections.h"
#include "stillray/stillray.h"

namespace stillray::test::reflections_test {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 20;
constexpr int kHeight = 12;

/// At x, turned by an angle; a field of view of 90 degrees across.
stillray_camera CameraAt(double x, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {{c, 0, s, -c * x, 0, 1, 0, 0, -s, 0, c, s * x, 0, 0, 0, 1},
          {1, 0, 0, 0, 0, 1.0 * kWidth / kHeight, 0, 0, 0, 0, -1.002, -0.2, 0, 0, -1, 0}};
}

CameraMatrices Matrices(const stillray_camera& camera) {
  std::array<double, 16> to_camera{};
  std::array<double, 16> projection{};
  std::memcpy(to_camera.data(), camera.world_to_camera, sizeof(camera.world_to_camera));
  std::memcpy(projection.data(), camera.projection, sizeof(camera.projection));
  return MatricesOf(to_camera, projection);
}

struct ReflectionsTest : testing::Test {
  ReflectionsTest() {
    for (size_t i = 0; i < depth.size(); ++i) {
      depth[i] = 3 + 0.01f * static_cast<float>(i);
      distance[i] = i % 5 == 0 ? 0.0f : 2 + 0.1f * static_cast<float>(i % 7);
    }
    hits.depth = &images[0];
    hits.hit_distance = &images[1];
    hits.roughness = &images[2];
    hits.camera = &now;
    hits.previous_camera = &before;
    hits.reflection_depth = &images[3];
    hits.reflection_motion = &images[4];
  }
  static stillray_image ImageOf(std::vector<float>* values, int channels) {
    return stillray_interleaved(values->data(), STILLRAY_FORMAT_FLOAT, channels, kWidth, kHeight);
  }
  std::string Message() {
    EXPECT_EQ(stillray_reflections_from_hits(&hits), STILLRAY_ERROR_INVALID_ARGUMENT);
    return stillray_error_message(nullptr);
  }

  std::vector<float> depth = std::vector<float>(kWidth * kHeight);
  std::vector<float> distance = depth;
  std::vector<float> roughness = depth;
  std::vector<float> out_depth = std::vector<float>(kWidth * kHeight, -7);
  std::vector<float> out_motion = std::vector<float>(2 * kWidth * kHeight, -7);
  stillray_image images[5] = {ImageOf(&depth, 1), ImageOf(&distance, 1), ImageOf(&roughness, 1),
                              ImageOf(&out_depth, 1), ImageOf(&out_motion, 2)};
  stillray_camera now = CameraAt(0.1, 0.02);
  stillray_camera before = CameraAt(0, 0);
  stillray_hits hits = STILLRAY_HITS_INIT;
};

TEST_F(ReflectionsTest, AreThoseOfTheCppFunction) {
  Guides guides;
  guides.depth = guides.roughness = Image1(kWidth, kHeight);
  Image1 plane(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    std::copy_n(&depth[static_cast<size_t>(y * kWidth)], kWidth, guides.depth.Row(y));
    std::copy_n(&distance[static_cast<size_t>(y * kWidth)], kWidth, plane.Row(y));
  }
  const Result<VirtualGuides> expected =
      ReflectionsFromHits(guides, plane, Matrices(now), Matrices(before));
  ASSERT_TRUE(expected.ok()) << expected.status().message();
  ASSERT_EQ(stillray_reflections_from_hits(&hits), STILLRAY_OK) << stillray_error_message(nullptr);
  int shown = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto i = static_cast<size_t>(y * kWidth + x);
      EXPECT_EQ(out_depth[i], expected->depth(x, y));
      EXPECT_EQ(out_motion[2 * i], expected->motion[0](x, y));
      EXPECT_EQ(out_motion[2 * i + 1], expected->motion[1](x, y));
      shown += out_depth[i] > 0 && std::abs(out_motion[2 * i]) > 0.1f ? 1 : 0;
    }
  }
  EXPECT_GT(shown, kWidth * kHeight / 2);
}

TEST_F(ReflectionsTest, SayWhatIsWrong) {
  hits.previous_camera = nullptr;
  EXPECT_EQ(Message(), "hits->previous_camera is NULL");
  hits.previous_camera = &now;
  now.projection[14] = 0;
  EXPECT_THAT(Message(), HasSubstr("the camera of this frame has no inverse or no perspective"));
  now = before;
  images[4].channels = 1;
  EXPECT_EQ(Message(), "image 'reflection_motion' has 1 channels, expected 2 to 4");
  images[1].width = 3;
  EXPECT_EQ(Message(), "image 'hit_distance' is 3x12, expected 20x12 as 'depth'");
  hits.hit_distance = nullptr;
  EXPECT_EQ(Message(), "image 'hit_distance' is not given");
  hits.struct_size = 0;
  EXPECT_EQ(Message(), "hits->struct_size is 0, expected sizeof(stillray_hits)");
  EXPECT_EQ(out_depth[0], -7);  // nothing was written
}

}  // namespace
}  // namespace stillray::test::reflections_test
