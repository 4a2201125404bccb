// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise --window both on a sequence that Blender rendered, against converged frames.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "program.h"
#include "stillray/aov.h"
#include "stillray/io.h"
#include "stillray/quality.h"

namespace stillray::cli_denoise_blender_test {
namespace {

class BlenderWindow : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* data = std::getenv("STILLRAY_TEST_DATA");
    folder_ =
        std::string(data != nullptr ? data : STILLRAY_DEFAULT_TEST_DATA) + "/sequences/blender_box";
    if (!std::filesystem::exists(folder_)) {
      GTEST_SKIP() << folder_
                   << " does not exist; STILLRAY_TEST_DATA names the folder with sequences/";
    }
  }

  /// PSNR on x / (1 + x) of the frames, in dB, of a run with these arguments.
  std::vector<double> Psnr(std::vector<std::string> arguments, const std::vector<int>& frames) {
    const TemporaryFolder out;
    arguments.insert(arguments.begin(), {"denoise", folder_ + "/frame_####.exr", "-o",
                                         out / "out.####.exr", "--window", "past"});
    const ProgramRun run = RunProgram(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.errors;
    std::vector<double> psnr;
    for (const int frame : frames) {
      const Result<Image3> test = ReadImage(FrameFileName(out / "out.####.exr", frame));
      const Result<Image3> reference =
          ReadImage(FrameFileName(folder_ + "/reference_####.exr", frame));
      if (!test.ok() || !reference.ok()) {
        ADD_FAILURE() << test.status().message() << reference.status().message();
        return std::vector<double>(frames.size());
      }
      const Result<ImageMetrics> metrics = CompareImages(*test, *reference, false);
      EXPECT_TRUE(metrics.ok()) << metrics.status().message();
      psnr.push_back(metrics.ok() ? metrics->psnr : 0.0);
    }
    return psnr;
  }

  std::string folder_;
};

TEST_F(BlenderWindow, BothReachesItsQuality) {
  const std::vector<double> psnr = Psnr({"--window", "both"}, {8, 16, 24});
  EXPECT_GE((psnr[0] + psnr[1] + psnr[2]) / 3, 41.5);
}

TEST_F(BlenderWindow, AFirstFrameIsThreeDecibelsBetter) {
  const double past = Psnr({"--frames", "16-24"}, {16})[0];
  const double both = Psnr({"--frames", "16-24", "--window", "both"}, {16})[0];
  EXPECT_GE(both, past + 3.0);
}

/// Blender's camera looks along -z, y up; `rows` turn its coordinates into the world's.
CameraMatrices StandardMatrices(const nlohmann::json& rows, double focal) {
  double c[4][4];
  for (size_t i = 0; i < 4; ++i) {
    for (size_t j = 0; j < 4; ++j) {
      c[i][j] = rows[i][j].get<double>();
    }
  }
  CameraMatrices m{};
  std::array<double, 16>& w = m.world_to_camera;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      w[4 * i + j] = c[i][j];
      w[12 + j] -= c[i][j] * c[i][3];
    }
  }
  w[15] = 1;
  const double fx = focal / 384;
  const double fy = focal / 216;
  for (size_t i = 0; i < 4; ++i) {
    const double z = w[4 * i + 2];
    m.world_to_ndc[4 * i] = fx * w[4 * i] - 0.5 * z;
    m.world_to_ndc[4 * i + 1] = -fy * w[4 * i + 1] - 0.5 * z;
    m.world_to_ndc[4 * i + 3] = -z;
  }
  return m;
}

// Vector holds halves: 0.004 pixels, plus the rounding of the printed matrices.
TEST_F(BlenderWindow, CamerasTellTheMotionOfWhatStandsStill) {
  const nlohmann::json cameras = nlohmann::json::parse(ReadText(folder_ + "/cameras.json"));
  const double focal = cameras["focal_pixels"].get<double>();
  const std::string path = folder_ + "/frame_0008.exr";
  const Result<ExrImage> image = ReadExr(path);
  ASSERT_TRUE(image.ok()) << image.status().message();
  const Result<AovLayout> layout = UnderstandAovs(*image, {}, path);
  ASSERT_TRUE(layout.ok());
  const Result<Frame> frame = ImportFrame(*image, *layout, {0, 0}, path);
  ASSERT_TRUE(frame.ok());
  const auto camera = [&](const char* number) {
    return StandardMatrices(cameras["camera_to_world"][number], focal);
  };
  const Image2 back = MotionFromCameras(frame->guides.depth, camera("8"), camera("7"));
  const Image2 on = MotionFromCameras(frame->guides.depth, camera("8"), camera("9"));
  const Image2 next = ImportNextMotion(*image, *layout, {});
  constexpr uint32_t kMover = 29 + 1;  // numbers begin at 1 in a frame
  double worst = 0;
  for (int y = 0; y < frame->height; ++y) {
    for (int x = 0; x < frame->width; ++x) {
      for (int c = 0; c < 2 && frame->guides.id(x, y) != kMover; ++c) {
        worst = std::max<double>(worst, std::fabs(back[c](x, y) - frame->guides.motion[c](x, y)));
        worst = std::max<double>(worst, std::fabs(on[c](x, y) - next[c](x, y)));
      }
    }
  }
  EXPECT_LT(worst, 0.01);
}

}  // namespace
}  // namespace stillray::cli_denoise_blender_test
