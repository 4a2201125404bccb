// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Whole sequences of built-in scenes on Vulkan against the CPU.
#include <algorithm>
#include <memory>

#include "gpu/device_test.h"
#include "stillray/render.h"
#include "stillray/scene.h"

namespace stillray {
namespace {

class Sequence : public test::DeviceTest {
 protected:
  struct Errors {
    double largest_rms = 0;      ///< of a frame
    double largest_share = 0;    ///< of pixels of a frame that are 2 % off, and more than a little
    double mean_brightness = 0;  ///< ratio, over all frames
  };
  /// Renders frames of the scene and gives each to both.
  Errors Run(const char* spec, const Settings& settings, DevicePrecision precision,
             RenderSettings render, int frames);
};

double Sum(const Image3& image) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        sum += static_cast<double>(image[c](x, y));
      }
    }
  }
  return sum;
}

Sequence::Errors Sequence::Run(const char* spec, const Settings& settings,
                               DevicePrecision precision, RenderSettings render, int frames) {
  const Result<Scene> scene = LoadScene(spec);
  EXPECT_TRUE(scene.ok());
  render.width = 96;
  render.height = 54;
  render.bounces = 2;
  std::unique_ptr<Renderer> renderer = std::move(Renderer::Create(*scene, render).value());
  Denoiser cpu = std::move(Denoiser::Create(settings).value());
  Denoiser tested = MakeDenoiser(settings, precision);
  Errors errors;
  double brightness = 0;
  double expected_brightness = 0;
  Frame frame;
  for (int i = 1; i <= frames; ++i) {
    RenderMoment moment;
    moment.frame_index = i;
    moment.seconds = (i - 1) / 30.0;
    moment.previous_seconds = (std::max(i, 2) - 2) / 30.0;
    EXPECT_TRUE(renderer->RenderFrame(moment, &frame).ok());
    DenoisedFrame expected;
    DenoisedFrame got;
    EXPECT_TRUE(cpu.Denoise(frame, &expected).ok());
    const Status status = tested.Denoise(frame, &got);
    EXPECT_TRUE(status.ok()) << status.message();
    for (int c = 0; c < 3; ++c) {
      const test::Difference d = test::Compare(got.colour[c], expected.colour[c], 2e-3);
      errors.largest_rms = std::max(errors.largest_rms, d.rms);
      errors.largest_share = std::max(errors.largest_share, d.outliers);
    }
    brightness += Sum(got.colour);
    expected_brightness += Sum(expected.colour);
  }
  errors.mean_brightness = brightness / expected_brightness;
  const bool sparse = render.cycle > 1;
  const bool halves = precision == DevicePrecision::kHalf;
  const std::string what = std::string(sparse ? "sparse " : "") + (halves ? "halves" : "floats");
  test::RecordLargest(what + " rms", errors.largest_rms, sparse && halves ? 0.15 : 0.03);
  test::RecordLargest(what + " outliers", errors.largest_share, sparse && halves ? 0.55 : 0.03);
  test::RecordLargest(what + " brightness", std::abs(errors.mean_brightness - 1),
                      sparse && halves ? 8e-3 : 5e-4);
  return errors;
}

Settings WithoutFxaa(std::string_view preset) {
  Settings settings = PresetSettings(preset).value();
  settings.fxaa = Fxaa::kOff;  // decides at thresholds
  return settings;
}

TEST_F(Sequence, ThirtyFramesInHalves) {
  for (const char* scene : {"builtin:cornell", "builtin:lights", "builtin:spheres"}) {
    const Errors e = Run(scene, WithoutFxaa("default"), DevicePrecision::kHalf, {}, 30);
    EXPECT_LT(e.largest_rms, 0.03) << scene;
    EXPECT_LT(e.largest_share, 0.03) << scene;
    EXPECT_NEAR(e.mean_brightness, 1, 5e-4) << scene;
  }
}

TEST_F(Sequence, ThirtyFramesWithFeedbackInHalves) {
  const Errors e = Run("builtin:cornell", WithoutFxaa("svgf"), DevicePrecision::kHalf, {}, 30);
  EXPECT_LT(e.largest_rms, 0.02);
  EXPECT_LT(e.largest_share, 0.03);
  EXPECT_NEAR(e.mean_brightness, 1, 5e-4);
}

TEST_F(Sequence, ThirtyFramesInFloats) {
  const Errors e = Run("builtin:cornell", WithoutFxaa("default"), DevicePrecision::kFloat, {}, 30);
  EXPECT_LT(e.largest_rms, 0.01);
  EXPECT_LT(e.largest_share, 0.01);
  EXPECT_NEAR(e.mean_brightness, 1, 1e-4);
}

TEST_F(Sequence, SparseFramesWithAndWithoutTheirGuides) {
  for (const GuideCoverage guides : {GuideCoverage::kFull, GuideCoverage::kSparse}) {
    RenderSettings render;
    render.cycle = 8;
    render.guides = guides;
    for (const char* preset : {"default", "psvgf"}) {
      const Errors f =
          Run("builtin:cornell", WithoutFxaa(preset), DevicePrecision::kFloat, render, 16);
      EXPECT_LT(f.largest_rms, 0.03) << preset;
      EXPECT_LT(f.largest_share, 0.01) << preset;
      EXPECT_NEAR(f.mean_brightness, 1, 5e-4) << preset;
      // Rounded guides accept other taps; the mean stays, but for the noise of few samples.
      constexpr int kSeeds = 5;
      double brightness = 0;
      for (render.seed = 0; render.seed < kSeeds; ++render.seed) {
        const Errors h =
            Run("builtin:cornell", WithoutFxaa(preset), DevicePrecision::kHalf, render, 16);
        EXPECT_LT(h.largest_rms, render.seed == 0 ? 0.12 : 0.15) << preset;
        EXPECT_LT(h.largest_share, render.seed == 0 ? 0.45 : 0.55) << preset;
        brightness += h.mean_brightness / kSeeds;
      }
      EXPECT_NEAR(brightness, 1, 3e-3) << preset;
      render.seed = 0;
    }
  }
}

}  // namespace
}  // namespace stillray
