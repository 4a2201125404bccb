// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames with virtual guides on the device: the pictures of the CPU.
#include <string>
#include <utility>
#include <vector>

#include "denoise/test_frames.h"
#include "gpu/device_test.h"

namespace stillray::virtual_guides_test {
namespace {

using test::MakeBusyFrame;

/// A busy frame whose lower half shows images that move otherwise than its surfaces; with
/// transmitted light, some of them through the surfaces.
Frame MakeFrame(int index, bool transmits) {
  constexpr int kWidth = 50;
  constexpr int kHeight = 38;
  Frame f = MakeBusyFrame(kWidth, kHeight, index);
  const auto image = [&](int first_row, VirtualGuides* guides) {
    guides->depth = Image1(kWidth, kHeight);
    guides->motion = Image2(kWidth, kHeight);
    guides->albedo = Image3(kWidth, kHeight);
    guides->motion[0].Fill(-0.5f);
    test::FillImage(&guides->depth, [&](int x, int y) {
      return y < first_row ? 0.0f : (x + index) % 16 < 8 ? 20.0f : 30.0f;
    });
    test::FillImage<3>(&guides->albedo, [&](int x, int y, int c) {
      return 0.2f + 0.1f * static_cast<float>((x / 3 + y / 3 + c) % 5);
    });
  };
  image(kHeight / 2, &f.reflection);
  if (transmits) {
    image(kHeight / 3, &f.refraction);
    f.guides.transmission_albedo = f.guides.albedo;
    f.signals.push_back({SignalKind::kIndirectTransmission, f.signals[1].radiance, Image1()});
  }
  return f;
}

class VirtualGuidesOnDevice : public test::DeviceTest {};

TEST_F(VirtualGuidesOnDevice, PicturesAreThoseOfTheCpu) {
  for (const bool transmits : {false, true}) {
    const Settings settings = test::WithoutFxaa(Settings());
    Denoiser denoiser = MakeDenoiser(settings, DevicePrecision::kFloat);
    test::ExpectReferencePictures(
        settings, &denoiser, 4, [&](int i) { return MakeFrame(i, transmits); },
        [](const std::string& name) { return test::ToleranceOf(name, DevicePrecision::kFloat); },
        transmits ? "transmission" : "reflection");
  }
}

TEST_F(VirtualGuidesOnDevice, FutureLightIsThatOfTheCpu) {
  const Settings settings = test::WithoutFxaa(Settings());
  Denoiser on_device = MakeDenoiser(settings, DevicePrecision::kFloat);
  Result<Denoiser> on_cpu = Denoiser::Create(settings, Backend::kReference);
  const auto picture = [&](Denoiser* denoiser) {
    FutureLight future;
    DenoisedFrame out;
    for (int i = 4; i-- > 0;) {
      const Status status = denoiser->Accumulate(MakeFrame(i, true), &future);
      EXPECT_TRUE(status.ok()) << status.message();
    }
    denoiser->Reset();
    EXPECT_TRUE(denoiser->Denoise(MakeFrame(0, true), future, &out).ok());
    return NamedImage{"colour", {out.colour[0], out.colour[1], out.colour[2]}};
  };
  test::ExpectImage(picture(&on_device), picture(&*on_cpu), test::kFloat, "with its future");
}

TEST_F(VirtualGuidesOnDevice, SavedHistoriesContinueWithTheSameBits) {
  Denoiser whole = MakeDenoiser(Settings(), DevicePrecision::kHalf);
  DenoisedFrame expected;
  DenoisedFrame out;
  std::vector<uint8_t> saved;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(whole.Denoise(MakeFrame(i, true), &expected).ok());
    if (i == 2) {
      saved = whole.SaveHistory().value();
    }
  }
  Denoiser resumed = MakeDenoiser(Settings(), DevicePrecision::kHalf);
  const Status restored = resumed.RestoreHistory(saved);
  ASSERT_TRUE(restored.ok()) << restored.message();
  for (int i = 3; i < 5; ++i) {
    ASSERT_TRUE(resumed.Denoise(MakeFrame(i, true), &out).ok());
  }
  EXPECT_TRUE(test::SameBits(out.colour, expected.colour));
  saved.resize(saved.size() - 40);
  EXPECT_EQ(resumed.RestoreHistory(saved).code(), StatusCode::kBadData);
}

}  // namespace
}  // namespace stillray::virtual_guides_test
