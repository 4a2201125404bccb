// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// stillray denoise on files with cameras and no motion.
#include <Imath/ImathMatrix.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli_denoise_shot.h"
#include "program.h"

namespace stillray::cli_denoise_cameras_test {
namespace {

using ::testing::HasSubstr;

/// The camera of the shot: 24 pixels of focal length, so that the wall at depth 4 goes by one pixel
/// where the camera goes by 1/6.
void CameraOfShot(const Shot& shot, int64_t frame, Imath::M44f* to_camera, Imath::M44f* to_ndc) {
  constexpr float kFocal = 24;
  const float x = static_cast<float>(shot.speed) * static_cast<float>(frame) * shot.depth / kFocal;
  *to_camera = Imath::M44f(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, 0, 0, 1);
  const Imath::M44f projection(kFocal / Shot::kWidth, 0, 0, 0, 0, -kFocal / Shot::kHeight, 0, 0,
                               0.5f, 0.5f, 1, 1, 0, 0, 0, 0);
  *to_ndc = *to_camera * projection;
}

/// Frames without motion, with the cameras that the standard has attributes for.
void WriteShotWithCameras(const std::string& pattern, const Shot& shot, int64_t first,
                          int64_t last) {
  for (int64_t frame = first; frame <= last; ++frame) {
    ExrImage image = ShotFrame(shot, frame);
    std::erase_if(image.channels, [](const Channel& channel) {
      return channel.name.starts_with("ViewLayer.Vector.");
    });
    const std::string path = FrameFileName(pattern, frame);
    ASSERT_TRUE(WriteExr(path + ".plain", image).ok());
    Imath::M44f to_camera;
    Imath::M44f to_ndc;
    CameraOfShot(shot, frame, &to_camera, &to_ndc);
    Imf::InputFile in((path + ".plain").c_str());
    Imf::Header header = in.header();
    Imf::addWorldToCamera(header, to_camera);
    Imf::addWorldToNDC(header, to_ndc);
    Imf::OutputFile out(path.c_str(), header);
    out.copyPixels(in);
  }
}

TEST(CliDenoiseCameras, StandInForMotion) {
  const TemporaryFolder folder;
  const Shot shot;
  const std::string in = folder / "in.####.exr";
  WriteShotWithCameras(in, shot, 1, 12);
  const ProgramRun run = RunProgram({"denoise", in, "-o", folder / "out.####.exr"});
  ASSERT_EQ(run.exit_code, 0) << run.errors;
  EXPECT_THAT(run.output, HasSubstr("derived from depth and the cameras"));
  EXPECT_THAT(run.output, HasSubstr("estimated from the guides for what moves by itself"));
  ASSERT_EQ(RunProgram({"denoise", in, "-o", folder / "alone.####.exr", "--aov", "motion=none"})
                .exit_code,
            0);
  ASSERT_EQ(
      RunProgram({"denoise", in, "-o", folder / "both.####.exr", "--window", "both"}).exit_code, 0);
  const double alone = ShotError(folder / "alone.####.exr", shot, 12, 12);
  EXPECT_LT(ShotError(folder / "out.####.exr", shot, 12, 12), alone / 3);
  EXPECT_LT(ShotError(folder / "both.####.exr", shot, 1, 12), alone / 3);
  // The same motion as a layer gives the same picture, but for the rounding of the matrices.
  WriteShot(folder / "vector.####.exr", shot, 1, 12);
  ASSERT_EQ(
      RunProgram({"denoise", folder / "vector.####.exr", "-o", folder / "v.####.exr"}).exit_code,
      0);
  EXPECT_NEAR(ShotError(folder / "out.####.exr", shot, 12),
              ShotError(folder / "v.####.exr", shot, 12), 1e-4);
}

TEST(CliDenoiseCameras, GivePositions) {
  const TemporaryFolder folder;
  const Shot shot;
  const std::string in = folder / "in.####.exr";
  WriteShotWithCameras(in, shot, 1, 3);
  const auto denoise = [&](const std::string& from) {
    return RunProgram(
        {"denoise", from, "-o", folder / "out.####.exr", "--set", "depth_weight=position"});
  };
  const ProgramRun with = denoise(in);
  EXPECT_EQ(with.exit_code, 0) << with.errors;
  WriteShot(folder / "vector.####.exr", shot, 1, 3);  // without cameras
  const ProgramRun without = denoise(folder / "vector.####.exr");
  EXPECT_NE(without.exit_code, 0);
  EXPECT_THAT(without.errors, HasSubstr("depth_weight=position needs the focal length"));
}

TEST(CliDenoiseCameras, AFrameWithoutOneIsNamed) {
  const TemporaryFolder folder;
  const std::string in = folder / "in.####.exr";
  WriteShotWithCameras(in, Shot(), 1, 3);
  ASSERT_TRUE(WriteFileAtomically(folder / "in.0002.exr",
                                  ReadText(folder / "in.0002.exr.plain").data(),
                                  ReadText(folder / "in.0002.exr.plain").size())
                  .ok());
  const ProgramRun run = RunProgram({"denoise", in, "-o", folder / "out.####.exr"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, HasSubstr("in.0002.exr: has no usable worldToCamera and worldToNDC"));
}

}  // namespace
}  // namespace stillray::cli_denoise_cameras_test
