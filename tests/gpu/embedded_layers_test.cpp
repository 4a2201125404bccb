// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Virtual guides in a caller's own command buffers: the pictures of the host API.
#include <gmock/gmock.h>

#include <string>
#include <utility>

#include "gpu/embedded_renderer.h"

namespace stillray::embedded_layers_test {
namespace {

using test::MakeGlass;
using test::MakeMirrors;
using test::PutOnDevice;
using ::testing::HasSubstr;

using EmbeddedLayers = test::EmbeddedRenderer;

/// MakeMirrors or MakeGlass with all images, or with none that may lack.
Frame MakeEmbedded(int index, bool all, bool glass) {
  Frame f = glass ? MakeGlass(51, 37, index, false) : MakeMirrors(51, 37, index, false);
  if (!all) {
    f.guides.id = f.reflection.id = f.refraction.id = Plane<uint32_t>();
    f.emission = Image3();
    f.guides.previous_normal = Image3();
  }
  return f;
}

TEST_F(EmbeddedLayers, PicturesAreThoseOfTheHost) {
  for (const auto& [all, glass] :
       {std::pair{true, false}, {false, false}, {true, true}, {false, true}}) {
    SCOPED_TRACE(all ? "all images" : "without those that may lack");
    SCOPED_TRACE(glass ? "glass" : "mirrors");
    const Frame first = MakeEmbedded(0, all, glass);
    const VulkanOptions options = Options(first, DevicePrecision::kHalf);
    const Result<DeviceMemory> need = VulkanDenoiser::MemoryNeed(context(), options);
    ASSERT_TRUE(need.ok()) << need.status().message();
    Result<VulkanDenoiser> embedded = VulkanDenoiser::Create(context(), options);
    ASSERT_TRUE(embedded.ok()) << embedded.status().message();
    EXPECT_EQ(embedded->memory().bytes, need->bytes);
    EXPECT_EQ(embedded->memory().allocations, need->allocations);
    MakeOutput(first);
    Denoiser from_host = MakeDenoiser(options.settings, DevicePrecision::kHalf);
    for (int index = 0; index < 6; ++index) {
      SCOPED_TRACE(index);
      Frame f = MakeEmbedded(index, all, glass);
      if (index == 3) {  // a frame without them begins anew, as does the one after it
        (glass ? f.refraction : f.reflection) = VirtualGuides();
      }
      const Frame on_device = PutOnDevice(device_, f);
      DenoisedFrame expected;
      ASSERT_TRUE(from_host.Denoise(f, &expected).ok());
      Run([&](VkCommandBuffer commands) {
        return embedded->Record(commands, FrameOf(f, on_device));
      });
      EXPECT_TRUE(test::SameBits(Picture(), expected.colour));
      ASSERT_TRUE(embedded->ForgetImages().ok());
    }
  }
}

TEST_F(EmbeddedLayers, PicturesOfSeveralSamplesAreThoseOfTheHost) {
  const Frame first = MakeMirrors(51, 37, 0, true);
  const VulkanOptions options = Options(first, DevicePrecision::kFloat);
  Result<VulkanDenoiser> embedded = VulkanDenoiser::Create(context(), options);
  ASSERT_TRUE(embedded.ok()) << embedded.status().message();
  MakeOutput(first);
  Denoiser from_host = MakeDenoiser(options.settings, DevicePrecision::kFloat);
  for (int index = 0; index < 3; ++index) {
    SCOPED_TRACE(index);
    const Frame f = MakeMirrors(51, 37, index, true);
    const Frame on_device = PutOnDevice(device_, f);
    DenoisedFrame expected;
    ASSERT_TRUE(from_host.Denoise(f, &expected).ok());
    Run([&](VkCommandBuffer commands) {
      return embedded->Record(commands, FrameOf(f, on_device));
    });
    const Image3 found = Picture();
    test::ExpectImage({"colour", {found[0], found[1], found[2]}},
                      {"colour", {expected.colour[0], expected.colour[1], expected.colour[2]}},
                      test::RescaledMoments(*device_), "embedded");
    ASSERT_TRUE(embedded->ForgetImages().ok());
  }
}

TEST_F(EmbeddedLayers, SaysWhatIsMissing) {
  const Frame f = MakeMirrors(51, 37, 0, false);
  const Frame on_device = PutOnDevice(device_, f);
  VulkanOptions options = Options(f, DevicePrecision::kHalf);
  MakeOutput(f);
  const auto message = [&](VulkanDenoiser* denoiser, auto change) {
    VulkanFrame frame = FrameOf(f, on_device);
    change(&frame);
    std::string text;
    Run([&](VkCommandBuffer commands) {
      text = denoiser->Record(commands, frame).message();
      return Status::Ok();
    });
    return text;
  };
  Result<VulkanDenoiser> with = VulkanDenoiser::Create(context(), options);
  ASSERT_TRUE(with.ok());
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->reflection.albedo = {}; }),
              HasSubstr("image 'reflection.albedo' is not given, beside 'reflection.depth'"));
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->roughness = {}; }),
              HasSubstr("image 'roughness' is not given"));
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->reflection.id = {}; }),
              HasSubstr("image 'reflection.id' is not given, beside 'id'"));
  EXPECT_EQ(message(&*with, [](VulkanFrame* v) { v->reflection = {}; }), "");
  options.virtual_guides = false;
  Result<VulkanDenoiser> without = VulkanDenoiser::Create(context(), options);
  ASSERT_TRUE(without.ok());
  EXPECT_LT(without->memory().bytes, with->memory().bytes);
  EXPECT_THAT(message(&*without, [](VulkanFrame*) {}),
              HasSubstr("virtual guides of reflected light are given, but the denoiser was made "
                        "without virtual guides"));
}

TEST_F(EmbeddedLayers, SaysWhatIsMissingForTransmittedLight) {
  const Frame f = MakeGlass(51, 37, 0, false);
  const Frame on_device = PutOnDevice(device_, f);
  VulkanOptions options = Options(f, DevicePrecision::kHalf);
  MakeOutput(f);
  Result<VulkanDenoiser> with = VulkanDenoiser::Create(context(), options);
  ASSERT_TRUE(with.ok());
  const auto message = [&](VulkanDenoiser* denoiser, const VulkanFrame& frame) {
    std::string text;
    Run([&](VkCommandBuffer commands) {
      text = denoiser->Record(commands, frame).message();
      return Status::Ok();
    });
    return text;
  };
  VulkanFrame frame = FrameOf(f, on_device);
  frame.refraction.motion = {};
  EXPECT_THAT(message(&*with, frame),
              HasSubstr("image 'refraction.motion' is not given, beside 'refraction.depth'"));
  frame.refraction = {};
  EXPECT_EQ(message(&*with, frame), "");
  // A denoiser for mirrors alone is given the images of glass.
  const Frame mirrors = MakeMirrors(51, 37, 0, false);
  Result<VulkanDenoiser> without =
      VulkanDenoiser::Create(context(), Options(mirrors, DevicePrecision::kHalf));
  ASSERT_TRUE(without.ok());
  EXPECT_LT(without->memory().bytes, with->memory().bytes);
  VulkanFrame of_mirrors = FrameOf(mirrors, on_device);
  of_mirrors.lights[4] = of_mirrors.lights[5] = {};
  of_mirrors.second_moments[4] = of_mirrors.second_moments[5] = {};
  of_mirrors.refraction = of_mirrors.reflection;
  EXPECT_THAT(message(&*without, of_mirrors),
              HasSubstr("virtual guides of transmitted light are given, but the denoiser was made "
                        "without transmission signals"));
}

}  // namespace
}  // namespace stillray::embedded_layers_test
