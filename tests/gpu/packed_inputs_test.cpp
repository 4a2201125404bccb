// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Images in the formats that real-time renderers keep: the pictures of their values as floats.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include <glm/packing.hpp>

#include "benchmarks/packed_inputs.h"
#include "core/half.h"
#include "gpu/renderer_test.h"

namespace stillray::packed_inputs_test {
namespace {

using test::kRendererHeight;
using test::kRendererWidth;
using test::Slot;

float AsHalf(float value) {
  return FloatFromHalf(HalfFromFloat(value));
}
float AsByte(float value) {
  return glm::unpackUnorm4x8(glm::packUnorm4x8(glm::vec4(value))).x;
}

/// A frame with the images of PackedInputs alone, whose values its formats hold.
Frame MakePackable(int index) {
  Frame f = test::MakeBusyFrame(kRendererWidth, kRendererHeight, index);
  f.samples = Image1();
  f.emission = f.background = Image3();
  f.guides.roughness = Image1();
  const auto round = [&](Image1* plane, float (*rounded)(float)) {
    for (int y = 0; y < f.height; ++y) {
      for (int x = 0; x < f.width; ++x) {
        (*plane)(x, y) = rounded((*plane)(x, y));
      }
    }
  };
  for (size_t c = 0; c < 3; ++c) {
    for (Signal& signal : f.signals) {
      round(&signal.radiance.channel[c], &AsHalf);
    }
    round(&f.guides.normal.channel[c], &AsHalf);
    round(&f.guides.albedo.channel[c], &AsByte);
    round(&f.guides.specular_albedo.channel[c], &AsByte);
  }
  round(&f.guides.motion.channel[0], &AsHalf);
  round(&f.guides.motion.channel[1], &AsHalf);
  return f;
}

class Packed : public test::RendererTest {
 protected:
  static VulkanFrame FrameOf(const vulkan::FrameInputs& in, const Frame& f) {
    const auto image = [](const vulkan::ImageRef& ref) {
      return VulkanImage{ref.view, ref.layout};
    };
    VulkanFrame frame;
    frame.index = f.index;
    frame.jitter_x = f.jitter_x;
    frame.jitter_y = f.jitter_y;
    frame.focal_pixels = f.focal_pixels;
    for (size_t k = 0; k < 4; ++k) {
      frame.lights[k] = image(in.lights[k]);
    }
    frame.depth = image(in.depth);
    frame.normal = image(in.normal);
    frame.id = image(in.id);
    frame.motion = image(in.motion);
    frame.albedo = image(in.albedos[0]);
    frame.specular_albedo = image(in.albedos[1]);
    return frame;
  }

  /// Begins a command buffer with the copy of the frame to the images.
  std::unique_ptr<vulkan::PackedInputs> BeginWith(const Frame& f, Slot* slot) const {
    auto packed = vulkan::PackedInputs::Create(&device_->context(), f);
    EXPECT_TRUE(packed.ok()) << packed.status().message();
    Begin(slot);
    (*packed)->Record(slot->commands);
    gpu::MemoryBarrier(device_->context(), slot->commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                       VK_ACCESS_SHADER_READ_BIT);
    return std::move(*packed);
  }
};

TEST_F(Packed, InputsGiveThePicturesOfTheirValues) {
  Prepare({}, 1);
  Slot& slot = slots_.front();
  for (const char* preset : {"svgf", "default"}) {
    const VulkanOptions o = options(preset, 1);
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(made.ok()) << made.status().message();
    Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
    for (int i = 0; i < 4; ++i) {
      SCOPED_TRACE(i);
      const Frame f = MakePackable(i);
      DenoisedFrame expected;
      ASSERT_TRUE(host.Denoise(f, &expected).ok());
      const auto packed = BeginWith(f, &slot);
      VulkanFrame frame = FrameOf(packed->inputs(), f);
      frame.colour = FreshView(*slot.colour, &slot);
      const Status recorded = made->Record(slot.commands, frame);
      ASSERT_TRUE(recorded.ok()) << recorded.message();
      ReadBack(slot.commands, slot);
      Submit(&slot);
      Wait(&slot);
      ExpectPicture(slot, expected.colour);
    }
  }
}

// The result as halves: that as floats, rounded to the nearest half.
TEST_F(Packed, ResultsMayBeHalves) {
  Prepare({}, 1);
  Slot& slot = slots_.front();
  gpu::Arena arena(&device_->context());
  const gpu::Image* halves =
      *arena.AddImage(VK_FORMAT_R16G16B16A16_SFLOAT, kRendererWidth, kRendererHeight, 0);
  const gpu::Buffer* bytes = *arena.AddBuffer(size_t{kRendererWidth} * kRendererHeight * 8, 0,
                                              gpu::BufferPlace::kDownload);
  ASSERT_TRUE(arena.Allocate().ok());
  const VulkanOptions o = options("default", 1);
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
  for (int i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    const Frame f = MakePackable(i);
    DenoisedFrame expected;
    ASSERT_TRUE(host.Denoise(f, &expected).ok());
    const auto packed = BeginWith(f, &slot);
    if (i == 0) {
      arena.RecordFirstUse(slot.commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                           VK_ACCESS_SHADER_WRITE_BIT);
    }
    VulkanFrame frame = FrameOf(packed->inputs(), f);
    frame.colour = {halves->view, VK_IMAGE_LAYOUT_GENERAL};
    frame.colour_is_half = true;
    const Status recorded = made->Record(slot.commands, frame);
    ASSERT_TRUE(recorded.ok()) << recorded.message();
    gpu::MemoryBarrier(device_->context(), slot.commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                       VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_ACCESS_TRANSFER_READ_BIT);
    const VkBufferImageCopy region = test::WholeImage(*halves);
    vk().CmdCopyImageToBuffer(slot.commands, halves->image, VK_IMAGE_LAYOUT_GENERAL, bytes->buffer,
                              1, &region);
    gpu::MemoryBarrier(device_->context(), slot.commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                       VK_ACCESS_HOST_READ_BIT);
    Submit(&slot);
    Wait(&slot);
    ASSERT_TRUE(arena.Invalidate().ok());
    const auto* pixels = static_cast<const uint16_t*>(bytes->mapped);
    for (int y = 0; y < kRendererHeight; ++y) {
      for (int x = 0; x < kRendererWidth; ++x) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_EQ(FloatFromHalf(pixels[4 * (y * kRendererWidth + x) + c]),
                    AsHalf(expected.colour[c](x, y)))
              << x << "," << y;
        }
      }
    }
  }
}

}  // namespace
}  // namespace stillray::packed_inputs_test
