// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise on a sequence that Blender rendered, against converged frames.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "program.h"
#include "stillray/io.h"
#include "stillray/quality.h"

namespace stillray {
namespace {

std::string SequenceFolder() {
  const char* folder = std::getenv("STILLRAY_TEST_DATA");
  return std::string(folder != nullptr ? folder : STILLRAY_DEFAULT_TEST_DATA) +
         "/sequences/blender_box";
}

struct Quality {
  double psnr = 0;  ///< mean of frames 8, 16 and 24
  double darkest = 10;
  double brightest = 0;
};

void Measure(const std::string& preset, Quality* quality) {
  const std::string folder = SequenceFolder();
  const TemporaryFolder out;
  const ProgramRun run = RunProgram(
      {"denoise", folder + "/frame_####.exr", "-o", out / "out.####.exr", "--preset", preset});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  for (const int frame : {8, 16, 24}) {
    const Result<Image3> test = ReadImage(FrameFileName(out / "out.####.exr", frame));
    const Result<Image3> reference =
        ReadImage(FrameFileName(folder + "/reference_####.exr", frame));
    ASSERT_TRUE(test.ok()) << test.status().message();
    ASSERT_TRUE(reference.ok()) << reference.status().message();
    const Result<ImageMetrics> metrics = CompareImages(*test, *reference, false);
    ASSERT_TRUE(metrics.ok()) << metrics.status().message();
    EXPECT_EQ(metrics->non_finite, 0);
    quality->psnr += metrics->psnr / 3;
    quality->darkest = std::min(quality->darkest, metrics->brightness);
    quality->brightest = std::max(quality->brightest, metrics->brightness);
  }
}

TEST(BlenderSequence, DefaultReachesItsQuality) {
  if (!std::filesystem::exists(SequenceFolder())) {
    GTEST_SKIP() << SequenceFolder()
                 << " does not exist; STILLRAY_TEST_DATA names the folder with sequences/";
  }
  Quality quality;
  ASSERT_NO_FATAL_FAILURE(Measure("default", &quality));
  EXPECT_GE(quality.psnr, 38.7);
  EXPECT_GE(quality.darkest, 0.98);
  EXPECT_LE(quality.brightest, 1.02);
}

// 36.3 dB is the figure of an independent implementation; the published filter darkens by 3 %.
TEST(BlenderSequence, SvgfIsThePublishedFilter) {
  if (!std::filesystem::exists(SequenceFolder())) {
    GTEST_SKIP() << SequenceFolder()
                 << " does not exist; STILLRAY_TEST_DATA names the folder with sequences/";
  }
  Quality quality;
  ASSERT_NO_FATAL_FAILURE(Measure("svgf", &quality));
  EXPECT_NEAR(quality.psnr, 36.3, 0.3);
  EXPECT_GE(quality.darkest, 0.96);
  EXPECT_LE(quality.brightest, 1.02);
}

}  // namespace
}  // namespace stillray
