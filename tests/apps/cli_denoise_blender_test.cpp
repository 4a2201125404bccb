// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise --window both on a sequence that Blender rendered, against converged frames.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "program.h"
#include "stillray/io.h"
#include "stillray/quality.h"

namespace stillray {
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
    arguments.insert(arguments.begin(),
                     {"denoise", folder_ + "/frame_####.exr", "-o", out / "out.####.exr"});
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
  EXPECT_GE((psnr[0] + psnr[1] + psnr[2]) / 3, 40.0);
}

TEST_F(BlenderWindow, AFirstFrameIsThreeDecibelsBetter) {
  const double past = Psnr({"--frames", "16-24"}, {16})[0];
  const double both = Psnr({"--frames", "16-24", "--window", "both"}, {16})[0];
  EXPECT_GE(both, past + 3.0);
}

}  // namespace
}  // namespace stillray
