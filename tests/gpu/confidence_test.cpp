// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames with a confidence in the light of the last frame, and with the normals of the last frame,
// on the device: the pictures of the CPU.
#include <limits>
#include <string>

#include "denoise/test_frames.h"
#include "gpu/device_test.h"

namespace stillray::confidence_test {
namespace {

constexpr int kWidth = 50;
constexpr int kHeight = 38;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// A busy frame with every kind of confidence, in blocks, and with normals of the last frame that
/// turn some surfaces; without both in every fourth frame.
Frame MakeFrame(int index) {
  Frame f = test::MakeBusyFrame(kWidth, kHeight, index);
  if (index % 4 != 3) {
    f.confidence = Image1(kWidth, kHeight);
    test::FillImage(&f.confidence, [&](int x, int y) {
      constexpr float kValues[] = {1, 0, 0.5f, 0.1f, 0.9f, -1, 2, kNan};
      return kValues[(x / 3 + y / 2 + index) % 8];
    });
    f.guides.previous_normal = f.guides.normal;
    test::FillImage<3>(&f.guides.previous_normal, [&](int x, int y, int c) {
      const int kind = (x / 5 + y / 3 + index) % 4;
      return kind == 0   ? kNan
             : kind == 1 ? 0.0f
             : kind == 2 ? 3 * f.guides.normal[c](x, y)
                         : f.guides.normal[(c + 1) % 3](x, y);
    });
  }
  return f;
}

Frame MakeMirrorFrame(int index) {
  Frame f = MakeFrame(index);
  f.reflection.depth = Image1(kWidth, kHeight);
  test::FillImage(&f.reflection.depth, [](int, int y) { return y < kHeight / 2 ? 0.0f : 20.0f; });
  f.reflection.motion = Image2(kWidth, kHeight);
  f.reflection.motion[0].Fill(-0.5f);
  return f;
}

/// Few pixels keep a history whose normals turn; in halves one whose limit is rounded counts for
/// more in their mean.
test::Tolerance HistoryToleranceOf(const std::string& name, DevicePrecision precision) {
  test::Tolerance t = test::ToleranceOf(name, precision);
  if (precision == DevicePrecision::kHalf && name.find("history") == 0) {
    t.rms = 0.02;
  }
  return t;
}

class ConfidenceOnDevice : public test::DeviceTest {};

TEST_F(ConfidenceOnDevice, PicturesAreThoseOfTheCpu) {
  for (const char* preset : {"default", "svgf", "psvgf", "temporal"}) {
    for (const DevicePrecision precision : {DevicePrecision::kFloat, DevicePrecision::kHalf}) {
      const Settings settings = test::WithoutFxaa(PresetSettings(preset).value());
      Denoiser denoiser = MakeDenoiser(settings, precision);
      test::ExpectReferencePictures(
          settings, &denoiser, 6, [](int i) { return MakeFrame(i); },
          [&](const std::string& name) { return HistoryToleranceOf(name, precision); }, preset);
    }
  }
}

// Of several samples, whose transmitted light has a wider tolerance.
TEST_F(ConfidenceOnDevice, PicturesOfVolumesAreThoseOfTheCpu) {
  const Settings settings = test::WithoutFxaa(Settings());
  for (const DevicePrecision precision : {DevicePrecision::kFloat, DevicePrecision::kHalf}) {
    Denoiser denoiser = MakeDenoiser(settings, precision);
    test::ExpectReferencePictures(
        settings, &denoiser, 4,
        [](int i) {
          Frame f = MakeFrame(i);
          f.samples = Image1(kWidth, kHeight);
          f.samples.Fill(16);
          f.signals.push_back(f.signals.front());
          f.signals.back().kind = SignalKind::kDirectTransmission;
          return f;
        },
        [&](const std::string& name) { return HistoryToleranceOf(name, precision); }, "volumes");
  }
}

TEST_F(ConfidenceOnDevice, PicturesOfMirrorsAreThoseOfTheCpu) {
  const Settings settings = test::WithoutFxaa(Settings());
  Denoiser denoiser = MakeDenoiser(settings, DevicePrecision::kFloat);
  test::ExpectReferencePictures(
      settings, &denoiser, 4, [](int i) { return MakeMirrorFrame(i); },
      [](const std::string& name) { return test::ToleranceOf(name, DevicePrecision::kFloat); },
      "mirrors");
}

TEST_F(ConfidenceOnDevice, FutureLightIsThatOfTheCpu) {
  const Settings settings = test::WithoutFxaa(Settings());
  Denoiser on_device = MakeDenoiser(settings, DevicePrecision::kFloat);
  Result<Denoiser> on_cpu = Denoiser::Create(settings, Backend::kReference);
  const auto picture = [&](Denoiser* denoiser) {
    FutureLight future;
    DenoisedFrame out;
    for (int i = 4; i-- > 0;) {
      const Status status = denoiser->Accumulate(MakeFrame(i), &future);
      EXPECT_TRUE(status.ok()) << status.message();
    }
    denoiser->Reset();
    EXPECT_TRUE(denoiser->Denoise(MakeFrame(0), future, &out).ok());
    return NamedImage{"colour", {out.colour[0], out.colour[1], out.colour[2]}};
  };
  test::ExpectImage(picture(&on_device), picture(&*on_cpu), test::kFloat, "with its future");
}

TEST_F(ConfidenceOnDevice, OneEverywhereHasTheBitsOfNone) {
  Denoiser with = MakeDenoiser(Settings(), DevicePrecision::kHalf);
  Denoiser without = MakeDenoiser(Settings(), DevicePrecision::kHalf);
  for (int i = 0; i < 5; ++i) {
    Frame f = test::MakeBusyFrame(kWidth, kHeight, i);
    DenoisedFrame expected;
    ASSERT_TRUE(without.Denoise(f, &expected).ok());
    f.confidence = Image1(kWidth, kHeight);
    f.confidence.Fill(1);
    DenoisedFrame out;
    ASSERT_TRUE(with.Denoise(f, &out).ok());
    EXPECT_TRUE(test::SameBits(out.colour, expected.colour)) << i;
  }
}

}  // namespace
}  // namespace stillray::confidence_test
