// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// --post of render and denoise: the pictures are those of the module, made from the same program's
// sharp pictures and guides.
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "post/depth_of_field.h"
#include "post/motion_blur.h"
#include "program.h"
#include "stillray/io.h"
#include "stillray/scene.h"

namespace stillray::cli_post_test {
namespace {

using ::testing::HasSubstr;

constexpr int kHeight = 48;
constexpr double kFov = 45;

using Words = std::vector<std::string>;

Words Joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

ProgramRun Render(const std::string& folder, const Words& more) {
  return RunProgram(Joined({"render", "builtin:faust", "-o", folder, "--size", "64x48", "--fps",
                            "6", "--frames", "20-21", "--float", "--format", "exr,png"},
                           more));
}

ProgramRun Denoise(const std::string& folder, const std::string& out, const Words& more) {
  return RunProgram(Joined(
      {"denoise", folder + "/noisy.####.exr", "-o", folder + "/" + out, "--no-check"}, more));
}

ExrImage Read(const std::string& path) {
  Result<ExrImage> image = ReadExr(path);
  EXPECT_TRUE(image.ok()) << image.status().message();
  return image.ok() ? std::move(image.value()) : ExrImage();
}

Image1 Layer(const ExrImage& image, const std::string& name) {
  const Channel* channel = image.Find(name);
  EXPECT_NE(channel, nullptr) << name;
  return channel == nullptr ? Image1(image.width, image.height) : channel->values;
}

Image3 Colour(const ExrImage& image) {
  Image3 colour;
  const char* names[] = {"R", "G", "B"};
  for (int c = 0; c < 3; ++c) {
    colour[c] = Layer(image, names[c]);
  }
  return colour;
}

double LargestDifference(const Image3& a, const Image3& b) {
  double most = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        most = std::fmax(
            most, std::fabs(static_cast<double>(a[c](x, y)) - static_cast<double>(b[c](x, y))));
      }
    }
  }
  return most;
}

/// Of kLens.
post::ThinLens LensOfFov(double yfov) {
  post::ThinLens lens;
  lens.radius = 0.5f;
  lens.focus = 3.0f;
  lens.pixels_per_tangent = static_cast<float>(kHeight / (2.0 * std::tan(yfov / 2)));
  return lens;
}

const Words kLens = {"--aperture", "0.5", "--focus", "3"};

TEST(CliPost, RenderBlursTheDenoisedPicture) {
  const TemporaryFolder folder;
  const ProgramRun plain = Render(folder / "plain", {"--aov", "depth,motion"});
  ASSERT_EQ(plain.exit_code, 0) << plain.errors;
  const ProgramRun blurred =
      Render(folder / "post",
             Joined({"--post", "motion_blur,dof", "--shutter", "0.8", "--aov", "depth"}, kLens));
  ASSERT_EQ(blurred.exit_code, 0) << blurred.errors;

  const ExrImage sharp = Read(folder / "plain/denoised.0021.exr");
  const ExrImage result = Read(folder / "post/denoised.0021.exr");
  Image3 expected = Colour(sharp);
  const Result<Scene> scene = LoadScene("builtin:faust");
  ASSERT_TRUE(scene.ok());
  const post::ThinLens lens = LensOfFov(static_cast<double>(scene->cameras[0].yfov));
  const Image1 depth = Layer(sharp, "depth.Z");
  ASSERT_TRUE(post::DepthOfField(lens, depth, &expected).ok());
  Image2 motion;
  motion[0] = Layer(sharp, "motion.X");
  motion[1] = Layer(sharp, "motion.Y");
  post::Shutter shutter;
  shutter.open = 0.8f;
  ASSERT_TRUE(post::MotionBlur(shutter, motion, depth, &expected).ok());
  EXPECT_LT(LargestDifference(Colour(result), expected), 1e-4);
  EXPECT_GT(LargestDifference(Colour(result), Colour(sharp)), 0.02);
  EXPECT_NE(ReadText(folder / "plain/denoised.0021.png"),
            ReadText(folder / "post/denoised.0021.png"));

  const nlohmann::json log = nlohmann::json::parse(ReadText(folder / "post/render.json"));
  EXPECT_EQ(log["post"], "dof,motion_blur shutter 0.8");
  EXPECT_EQ(log["post_aperture"], "0.5");
  EXPECT_EQ(log["aperture"], "0");  // a pinhole is traced
  const nlohmann::json before = nlohmann::json::parse(ReadText(folder / "plain/render.json"));
  EXPECT_EQ(before["post"], "");
}

TEST(CliPost, DenoiseBlursTheDenoisedPicture) {
  const TemporaryFolder folder;
  const ProgramRun rendered = Render(folder.path(), {"--save-inputs"});
  ASSERT_EQ(rendered.exit_code, 0) << rendered.errors;
  const ProgramRun plain = Denoise(folder.path(), "plain", {});
  ASSERT_EQ(plain.exit_code, 0) << plain.errors;
  const ProgramRun blurred =
      Denoise(folder.path(), "post", Joined({"--post", "dof", "--fov", "45"}, kLens));
  ASSERT_EQ(blurred.exit_code, 0) << blurred.errors;
  const ExrImage sharp = Read(folder / "plain/noisy.0021.exr");
  const ExrImage result = Read(folder / "post/noisy.0021.exr");
  Image3 expected = Colour(sharp);
  const double yfov = kFov * std::acos(-1.0) / 180;
  ASSERT_TRUE(post::DepthOfField(LensOfFov(yfov), Layer(sharp, "depth.Z"), &expected).ok());
  EXPECT_LT(LargestDifference(Colour(result), expected), 1e-4);
  EXPECT_GT(LargestDifference(Colour(result), Colour(sharp)), 0.02);

  const ProgramRun moved =
      Denoise(folder.path(), "moved", {"--post", "motion_blur", "--shutter", "1"});
  ASSERT_EQ(moved.exit_code, 0) << moved.errors;
  EXPECT_GT(LargestDifference(Colour(Read(folder / "moved/noisy.0021.exr")), Colour(sharp)), 0.02);

  const ProgramRun no_fov =
      Denoise(folder.path(), "no_fov", {"--post", "dof", "--aperture", "0.05"});
  EXPECT_EQ(no_fov.exit_code, 2);
  EXPECT_THAT(no_fov.errors, HasSubstr("expected --fov DEGREES"));
}

TEST(CliPost, ARunIsResumedWithItsOwnEffectsOnly) {
  const TemporaryFolder folder;
  const Words dof = Joined({"--post", "dof"}, kLens);
  ASSERT_EQ(Render(folder.path(), dof).exit_code, 0);
  const ProgramRun same = Render(folder.path(), Joined({"--resume"}, dof));
  EXPECT_EQ(same.exit_code, 0) << same.errors;
  const ProgramRun without = Render(folder.path(), Joined({"--resume"}, kLens));
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.errors, HasSubstr("cannot resume"));
}

struct Wrong {
  Words words;
  const char* message;
};

TEST(CliPost, RenderNamesWhatIsWrong) {
  const TemporaryFolder folder;
  const Wrong wrongs[] = {
      {{"--post", "motion_blurr"}, "did you mean motion_blur"},
      {{"--post", "dof,bloom", "--aperture", "1"}, "--post has 'bloom', expected a list of dof"},
      {{"--post", "motion_blur", "--shutter", "1.5"}, "found '1.5', expected 0 to 1"},
      {{"--post", "motion_blur", "--shutter", "-0.5"}, "expected 0 to 1"},
      {{"--post", "motion_blur", "--shutter", "nan"}, "found 'nan'"},
      {{"--shutter", "0.5"}, "expected --post motion_blur"},
      {{"--post", "dof"}, "expected --aperture RADIUS or f/N"},
      {{"--post", "dof", "--aperture", "0.1", "--blades", "6"}, "expected no --blades"},
      {{"--post", "motion_blur", "--spp", "1/4", "--guides", "sparse"}, "--guides full"},
  };
  for (const Wrong& wrong : wrongs) {
    const ProgramRun run = Render(folder / "out", wrong.words);
    EXPECT_EQ(run.exit_code, 2) << wrong.message;
    EXPECT_THAT(run.errors, HasSubstr(wrong.message));
  }
}

TEST(CliPost, DenoiseNamesWhatIsWrong) {
  const TemporaryFolder folder;
  const Wrong wrongs[] = {
      {{"--post", "dfo", "--aperture", "0.1"}, "did you mean dof"},
      {{"--post", "dof"}, "expected --aperture RADIUS or f/N"},
      {{"--post", "dof", "--aperture", "-1"}, "--aperture is '-1'"},
      {{"--post", "dof", "--aperture", "1", "--focus", "far"}, "--focus is 'far'"},
      {{"--post", "dof", "--aperture", "1", "--fov", "180"}, "found '180', expected 0.1 to 179"},
      {{"--aperture", "0.1"}, "--aperture is for depth of field, expected --post dof"},
      {{"--post", "motion_blur", "--fov", "40"}, "--fov is for depth of field"},
      {{"--post", "motion_blur", "--passes"}, "--passes and --post exclude each other"},
  };
  for (const Wrong& wrong : wrongs) {
    const ProgramRun run = Denoise(folder.path(), "out", wrong.words);
    EXPECT_EQ(run.exit_code, 2) << wrong.message;
    EXPECT_THAT(run.errors, HasSubstr(wrong.message));
  }
}

}  // namespace
}  // namespace stillray::cli_post_test
