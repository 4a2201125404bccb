// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Whole scenes against the brightness that another renderer found.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "test_scenes.h"

namespace stillray::render {
namespace {

struct RealScene {
  const char* file;
  int width;  // the shape it was framed for, at a tenth of the size
  int height;
  float luminance;  // mean, keyframe 0
};

class RealSceneTest : public ::testing::TestWithParam<RealScene> {};

std::string DataFolder() {
  const char* folder = std::getenv("STILLRAY_TEST_DATA");
  return folder != nullptr ? folder : STILLRAY_TEST_DATA_DEFAULT;
}

TEST_P(RealSceneTest, IsAsBrightAsItShouldBe) {
  const std::string path = DataFolder() + "/scenes/" + GetParam().file;
  if (!std::filesystem::exists(path)) {
    GTEST_SKIP() << path << " is not there; set STILLRAY_TEST_DATA";
  }
  Result<Scene> scene = LoadGltf(path);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  RenderSettings settings = SmallSettings(GetParam().width, GetParam().height, 1);
  settings.jitter = true;
  settings.bounces = 16;
  const Image3 picture = RenderMean(*scene, settings, 64);
  EXPECT_NEAR(Luminance709(Mean(picture)) / GetParam().luminance, 1.0f, 0.1f);
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealSceneTest,
                         ::testing::Values(RealScene{"kitchen.glb", 128, 72, 1.28f},
                                           RealScene{"coffee.glb", 80, 100, 0.156f},
                                           RealScene{"lamp.glb", 102, 102, 0.298f}));

}  // namespace
}  // namespace stillray::render
