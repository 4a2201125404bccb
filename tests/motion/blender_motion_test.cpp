// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Estimated motion of a sequence that Blender rendered, against its Vector pass.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "motion/estimate_motion.h"
#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray::motion {
namespace {

/// The number of the one object that moves by itself: IndexOB 29.
constexpr uint32_t kMover = 30;

std::string SequenceFolder() {
  const char* folder = std::getenv("STILLRAY_TEST_DATA");
  return std::string(folder != nullptr ? folder : STILLRAY_DEFAULT_TEST_DATA) +
         "/sequences/blender_box";
}

Frame Load(int frame) {
  const std::string path = FrameFileName(SequenceFolder() + "/frame_####.exr", frame);
  const Result<ExrImage> image = ReadExr(path);
  EXPECT_TRUE(image.ok()) << image.status().message();
  const Result<AovLayout> layout = UnderstandAovs(*image, {}, path);
  EXPECT_TRUE(layout.ok()) << layout.status().message();
  Result<Frame> result = ImportFrame(*image, *layout, {0, 0}, path);
  EXPECT_TRUE(result.ok()) << result.status().message();
  return std::move(result.value());
}

/// Whether a pixel's surface was in view in the previous frame.
bool WasSeen(const Frame& now, const Frame& before, int x, int y) {
  const float u = static_cast<float>(x) + now.guides.motion[0](x, y);
  const float v = static_cast<float>(y) + now.guides.motion[1](x, y);
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(now.width - 1) &&
        v < static_cast<float>(now.height - 1))) {
    return false;
  }
  for (int i = 0; i < 4; ++i) {
    if (before.guides.id(static_cast<int>(u) + (i & 1), static_cast<int>(v) + (i >> 1)) ==
        now.guides.id(x, y)) {
      return true;
    }
  }
  return false;
}

struct Errors {
  std::vector<float> still;
  std::vector<float> moving;
};

double PartBelow(const std::vector<float>& errors, float limit) {
  return static_cast<double>(
             std::count_if(errors.begin(), errors.end(), [&](float e) { return e < limit; })) /
         static_cast<double>(errors.size());
}

/// Over several frames.
Errors Measure() {
  Errors errors;
  for (const int frame : {2, 8, 12, 16, 24}) {
    const Frame before = Load(frame - 1);
    const Frame now = Load(frame);
    EstimateInput input;
    input.now = &now.guides;
    input.before = &before.guides;
    const EstimatedMotion estimated = EstimateMotion(input);
    EXPECT_TRUE(estimated.found_camera) << frame;
    EXPECT_LT(estimated.unknown, 0.01) << frame;
    for (int y = 0; y < now.height; ++y) {
      for (int x = 0; x < now.width; ++x) {
        if (WasSeen(now, before, x, y)) {
          (now.guides.id(x, y) == kMover ? errors.moving : errors.still)
              .push_back(std::hypot(estimated.motion[0](x, y) - now.guides.motion[0](x, y),
                                    estimated.motion[1](x, y) - now.guides.motion[1](x, y)));
        }
      }
    }
  }
  return errors;
}

// Measured: 0.97 to 1 of the still pixels within 0.3 pixels in each frame, all of the moving ones
// within one pixel and 0.65 to 0.99 within 0.3.
TEST(BlenderMotion, IsFoundFromGuidesAlone) {
  if (!std::filesystem::exists(SequenceFolder())) {
    GTEST_SKIP() << SequenceFolder()
                 << " does not exist; STILLRAY_TEST_DATA names the folder with sequences/";
  }
  const Errors errors = Measure();
  EXPECT_GT(PartBelow(errors.still, 0.3f), 0.97);
  EXPECT_GT(PartBelow(errors.still, 1.0f), 0.99);
  EXPECT_GT(PartBelow(errors.moving, 0.3f), 0.7);
  EXPECT_GT(PartBelow(errors.moving, 1.0f), 0.98);
}

}  // namespace
}  // namespace stillray::motion
