// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The denoiser in a caller's own command buffers, in C++ and in C.
#include <gmock/gmock.h>

#include <cstring>
#include <string>

#include "denoise/plan.h"
#include "denoise/sparse_frames.h"
#include "denoise/stages/tonemap.h"
#include "denoise/test_frames.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "gpu/device_test.h"
#include "gpu/frame_run.h"
#include "gpu/watched_device.h"
#include "stillray/vulkan.h"
#include "stillray/vulkan.hpp"

namespace stillray::embedding_test {
namespace {

using test::Barrier;
using test::MakeBusyFrame;
using test::RunFrame;
using test::Upload;
using test::watched::barriers;
using test::watched::dispatches;
using test::watched::forbidden_calls;
using test::watched::memory_calls;
using ::testing::HasSubstr;

constexpr int kWidth = 61;
constexpr int kHeight = 37;

class Embedding : public test::DeviceTest {
 protected:
  VulkanContext context() {
    return {instance_->handle(), device_->context().physical, device_->context().device,
            test::watched::Watch(instance_->get_instance_proc_addr())};
  }
  VulkanOptions options(std::string_view preset) {
    VulkanOptions o;
    o.settings = PresetSettings(preset).value();
    o.width = kWidth;
    o.height = kHeight;
    o.timestamps = device_->has_timestamps();
    return o;
  }
};

/// A frame in images of the device, as a renderer would have it.
VulkanFrame FrameOf(const vulkan::FrameInputs& in, const Frame& frame) {
  const auto image = [](const vulkan::ImageRef& ref) { return VulkanImage{ref.view, ref.layout}; };
  VulkanFrame f;
  f.index = frame.index;
  f.jitter_x = frame.jitter_x;
  f.jitter_y = frame.jitter_y;
  f.focal_pixels = frame.focal_pixels;
  for (int k = 0; k < kSignalKindCount; ++k) {
    f.lights[k] = image(in.lights[k]);
    f.second_moments[k] = image(in.second_moments[k]);
  }
  f.depth = image(in.depth);
  f.normal = image(in.normal);
  f.id = image(in.id);
  f.motion = image(in.motion);
  f.albedo = image(in.albedos[0]);
  f.specular_albedo = image(in.albedos[1]);
  f.emission = image(in.emission);
  f.background = image(in.background);
  f.samples = image(in.samples);
  f.roughness = image(in.roughness);
  f.confidence = image(in.confidence);
  f.previous_normal = image(in.previous_normal);
  f.colour = image(in.colour);
  double samples = 0;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      samples += static_cast<double>(frame.samples(x, y));
    }
  }
  f.samples_per_pixel =
      static_cast<float>(samples / (static_cast<double>(frame.width) * frame.height));
  return f;
}

stillray_vulkan_frame CFrameOf(const VulkanFrame& cpp) {
  stillray_vulkan_frame frame = STILLRAY_VULKAN_FRAME_INIT;
  frame.index = cpp.index;
  frame.samples_per_pixel = cpp.samples_per_pixel;
  frame.jitter_x = cpp.jitter_x;
  frame.jitter_y = cpp.jitter_y;
  frame.focal_pixels = cpp.focal_pixels;
  const auto put = [&](int slot, const VulkanImage& image) {
    frame.images[slot] = {image.view, image.layout};
  };
  for (int k = 0; k < 4; ++k) {
    put(STILLRAY_VULKAN_DIRECT_DIFFUSE + k, cpp.lights[k]);
  }
  put(STILLRAY_VULKAN_DEPTH, cpp.depth);
  put(STILLRAY_VULKAN_NORMAL, cpp.normal);
  put(STILLRAY_VULKAN_ID, cpp.id);
  put(STILLRAY_VULKAN_MOTION, cpp.motion);
  put(STILLRAY_VULKAN_ALBEDO, cpp.albedo);
  put(STILLRAY_VULKAN_SPECULAR_ALBEDO, cpp.specular_albedo);
  put(STILLRAY_VULKAN_EMISSION, cpp.emission);
  put(STILLRAY_VULKAN_BACKGROUND, cpp.background);
  put(STILLRAY_VULKAN_SAMPLES, cpp.samples);
  put(STILLRAY_VULKAN_ROUGHNESS, cpp.roughness);
  put(STILLRAY_VULKAN_CONFIDENCE, cpp.confidence);
  put(STILLRAY_VULKAN_PREVIOUS_NORMAL, cpp.previous_normal);
  put(STILLRAY_VULKAN_COLOUR, cpp.colour);
  return frame;
}

void ExpectSameBits(const Image3& a, const Image3& b) {
  for (int y = 0; y < b.height(); ++y) {
    for (int x = 0; x < b.width(); ++x) {
      ASSERT_EQ(a[1](x, y), b[1](x, y)) << x << "," << y;
    }
  }
}

TEST_F(Embedding, GivesThePicturesOfTheHostApiWithoutHiddenWork) {
  const Frame first = MakeBusyFrame(kWidth, kHeight, 0);
  auto upload = Upload(device_->context(), first);
  for (const char* preset : {"default", "svgf", "psvgf"}) {
    const VulkanOptions o = options(preset);
    const Result<DeviceMemory> need = VulkanDenoiser::MemoryNeed(context(), o);
    ASSERT_TRUE(need.ok()) << need.status().message();
    memory_calls = 0;
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(made.ok()) << made.status().message();
    EXPECT_EQ(made->memory().bytes, need->bytes);
    EXPECT_EQ(made->memory().allocations, need->allocations);
    EXPECT_EQ(memory_calls, need->allocations);
    Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
    for (int i = 0; i < 30; ++i) {
      const Frame f = MakeBusyFrame(kWidth, kHeight, i);
      DenoisedFrame expected;
      ASSERT_TRUE(host.Denoise(f, &expected).ok());
      Image3 colour;
      RunFrame(device_.get(), upload.get(), f, &colour, [&](VkCommandBuffer commands) {
        forbidden_calls = 0;
        const Status recorded = made->Record(commands, FrameOf(upload->inputs(), f));
        EXPECT_TRUE(recorded.ok()) << recorded.message();
        // At first descriptor sets are taken from the pool, until all ways in which images change
        // places have been seen; nothing else, ever.
        EXPECT_TRUE(i < 20 || forbidden_calls == 0) << preset << " frame " << i;
      });
      ExpectSameBits(colour, expected.colour);
    }
    EXPECT_EQ(made->timings().empty(), !o.timestamps);
  }
}

// Every dispatch and every barrier costs a device a few microseconds. docs/gpu.md states them.
TEST_F(Embedding, FramesHaveAKnownNumberOfDispatchesAndBarriers) {
  struct Known {
    const char* preset;
    int dispatches;
    int barriers;
  };
  auto upload = Upload(device_->context(), MakeBusyFrame(kWidth, kHeight, 0));
  for (const Known& known : {Known{"temporal", 7, 7}, Known{"svgf", 18, 18}, Known{"psvgf", 19, 19},
                             Known{"default", 47, 44}}) {
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), options(known.preset));
    ASSERT_TRUE(made.ok()) << made.status().message();
    for (int i = 0; i < 4; ++i) {
      const Frame f = MakeBusyFrame(kWidth, kHeight, i);
      Image3 colour;
      RunFrame(device_.get(), upload.get(), f, &colour, [&](VkCommandBuffer commands) {
        dispatches = 0;
        barriers = 0;
        EXPECT_TRUE(made->Record(commands, FrameOf(upload->inputs(), f)).ok());
      });
    }
    EXPECT_EQ(dispatches, known.dispatches) << known.preset;
    EXPECT_EQ(barriers, known.barriers) << known.preset;
  }
}

// So does every byte that a pass reads or writes; docs/gpu.md states them, for frames of one sample
// without inputs that may lack.
TEST_F(Embedding, FramesMoveAKnownNumberOfBytes) {
  struct Known {
    const char* preset;
    int halves;  ///< bytes per pixel
    int floats;
  };
  constexpr int kSide = 256;
  const Frame f = test::MakeWall(kSide, kSide);
  auto upload = Upload(device_->context(), f);
  for (const Known& known : {Known{"temporal", 382, 764}, Known{"svgf", 1126, 2252},
                             Known{"psvgf", 542, 1084}, Known{"default", 2629, 5258}}) {
    for (const vulkan::Storage storage : {vulkan::Storage::kHalf, vulkan::Storage::kFloat}) {
      vulkan::PipelineOptions o;
      o.settings = PresetSettings(known.preset).value();
      o.width = o.height = kSide;
      o.storage = storage;
      auto pipeline = vulkan::FramePipeline::Create(&device_->context(), o);
      ASSERT_TRUE(pipeline.ok()) << pipeline.status().message();
      gpu::CommandList commands(&device_->context());
      FrameFacts facts = FactsOf(f);
      for (facts.index = 0; facts.index < 4; ++facts.index) {
        const FramePlan plan = MakePlan(o.settings, facts, (*pipeline)->progress());
        ASSERT_TRUE((*pipeline)->Record(&commands, plan, facts, upload->inputs(), nullptr).ok());
        commands.Clear();
      }
      const double per_pixel = static_cast<double>((*pipeline)->pass_bytes()) / (kSide * kSide);
      const int expected = storage == vulkan::Storage::kHalf ? known.halves : known.floats;
      EXPECT_NEAR(per_pixel, expected, 1) << known.preset << " " << static_cast<int>(storage);
    }
  }
}

TEST_F(Embedding, TakesConfidenceAndPreviousNormalsInCppAndInC) {
  const auto frame_of = [](int i) {
    Frame f = MakeBusyFrame(kWidth, kHeight, i);
    f.confidence = Image1(kWidth, kHeight);
    test::FillImage(&f.confidence, [&](int x, int) { return static_cast<float>(x) / kWidth; });
    f.guides.previous_normal = Image3(kWidth, kHeight);
    test::FillImage<3>(&f.guides.previous_normal,
                       [](int, int y, int c) { return c == 2 && y % 2 == 0 ? 1.0f : 0.0f; });
    return f;
  };
  auto upload = Upload(device_->context(), frame_of(0));
  const VulkanOptions o = options("default");
  Result<VulkanDenoiser> in_cpp = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(in_cpp.ok()) << in_cpp.status().message();
  const VulkanContext given = context();
  stillray_vulkan_context c = STILLRAY_VULKAN_CONTEXT_INIT;
  c.instance = given.instance;
  c.physical_device = given.physical_device;
  c.device = given.device;
  c.get_instance_proc_addr = given.get_instance_proc_addr;
  stillray_vulkan_options c_options = STILLRAY_VULKAN_OPTIONS_INIT;
  c_options.width = kWidth;
  c_options.height = kHeight;
  stillray_vulkan_denoiser* in_c = nullptr;
  ASSERT_EQ(stillray_vulkan_create(STILLRAY_ABI_VERSION, &c, &c_options, &in_c), STILLRAY_OK);
  Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
  for (int i = 0; i < 3; ++i) {
    const Frame f = frame_of(i);
    DenoisedFrame expected;
    ASSERT_TRUE(host.Denoise(f, &expected).ok());
    const VulkanFrame frame = FrameOf(upload->inputs(), f);
    Image3 colour;
    RunFrame(device_.get(), upload.get(), f, &colour,
             [&](VkCommandBuffer commands) { EXPECT_TRUE(in_cpp->Record(commands, frame).ok()); });
    ExpectSameBits(colour, expected.colour);
    stillray_vulkan_frame c_frame = CFrameOf(frame);
    RunFrame(device_.get(), upload.get(), f, &colour, [&](VkCommandBuffer commands) {
      EXPECT_EQ(stillray_vulkan_record(in_c, commands, &c_frame), STILLRAY_OK)
          << stillray_vulkan_error_message(in_c);
    });
    ExpectSameBits(colour, expected.colour);
  }
  stillray_vulkan_release(in_c);
}

TEST_F(Embedding, CompletesGuidesAsTheHostApiDoes) {
  const test::SparseCase sparse = {kWidth, kHeight, 12, 0.7f, true};
  auto upload = Upload(device_->context(), test::MakeSparseFrame(sparse, 0));
  VulkanOptions o = options("default");
  const uint64_t without = VulkanDenoiser::MemoryNeed(context(), o)->bytes;
  o.incomplete_guides = true;
  const DeviceMemory need = *VulkanDenoiser::MemoryNeed(context(), o);
  EXPECT_GT(need.bytes, without);
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  EXPECT_EQ(made->memory().bytes, need.bytes);
  EXPECT_EQ(made->memory().allocations, need.allocations);
  Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
  for (int i = 0; i < 24; ++i) {
    const Frame f = test::MakeSparseFrame(sparse, i);
    DenoisedFrame expected;
    ASSERT_TRUE(host.Denoise(f, &expected).ok());
    VulkanFrame frame = FrameOf(upload->inputs(), f);
    Image3 colour;
    RunFrame(device_.get(), upload.get(), f, &colour, [&](VkCommandBuffer commands) {
      VulkanFrame incomplete = frame;
      incomplete.samples = VulkanImage();
      EXPECT_THAT(made->Record(commands, incomplete).message(),
                  HasSubstr("image 'samples' is not given"));
      forbidden_calls = 0;
      const Status recorded = made->Record(commands, frame);
      EXPECT_TRUE(recorded.ok()) << recorded.message();
      EXPECT_TRUE(i < 20 || forbidden_calls == 0) << "frame " << i;
    });
    ExpectSameBits(colour, expected.colour);
  }
}

TEST_F(Embedding, ShowsThePictureAsTonemapDoes) {
  const gpu::DeviceContext& c = device_->context();
  const Frame f = MakeBusyFrame(kWidth, kHeight, 0);
  auto upload = Upload(c, f);
  gpu::Arena arena(&c);
  const gpu::Image* display = *arena.AddImage(VK_FORMAT_R8G8B8A8_UNORM, kWidth, kHeight, 0);
  const gpu::Buffer* bytes = *arena.AddBuffer(kWidth * kHeight * 4, 0, gpu::BufferPlace::kDownload);
  ASSERT_TRUE(arena.Allocate().ok());
  for (const char* curve : {"linear", "reinhard", "filmic", "aces"}) {
    VulkanOptions o = options("default");
    ASSERT_TRUE(SetParameter(&o.settings, "tonemap", curve).ok());
    ASSERT_TRUE(SetParameter(&o.settings, "exposure", "0.5").ok());
    o.precision = DevicePrecision::kFloat;
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(made.ok());
    Image3 colour;
    RunFrame(device_.get(), upload.get(), f, &colour, [&](VkCommandBuffer commands) {
      VkImageMemoryBarrier barrier = {};
      barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
      barrier.dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
      barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
      barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
      barrier.image = display->image;
      barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
      c.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                              VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 0, nullptr, 0, nullptr, 1,
                              &barrier);
      VulkanFrame frame = FrameOf(upload->inputs(), f);
      frame.display.view = display->view;
      EXPECT_TRUE(made->Record(commands, frame).ok());
      Barrier(c, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
              VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
      VkBufferImageCopy region = {};
      region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
      region.imageExtent = {kWidth, kHeight, 1};
      c.vk.CmdCopyImageToBuffer(commands, display->image, VK_IMAGE_LAYOUT_GENERAL, bytes->buffer, 1,
                                &region);
    });
    ASSERT_TRUE(arena.Invalidate().ok());
    std::vector<uint8_t> expected(kWidth * kHeight * 3);
    reference::Tonemap(colour, TonemapOf(0.5f, o.settings.tonemap, 0, 0), expected.data());
    const auto* shown = static_cast<const uint8_t*>(bytes->mapped);
    int differ = 0;
    for (int i = 0; i < kWidth * kHeight; ++i) {
      for (int k = 0; k < 3; ++k) {
        const int difference =
            std::abs(shown[4 * i + k] - expected[static_cast<size_t>(3 * i + k)]);
        ASSERT_LE(difference, 1) << curve;
        differ += difference;
      }
    }
    EXPECT_LT(differ, kWidth * kHeight * 3 / 200) << curve;
  }
}

TEST_F(Embedding, SaysWhatIsMissing) {
  const Frame f = MakeBusyFrame(kWidth, kHeight, 4);
  auto upload = Upload(device_->context(), f);
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), options("default"));
  ASSERT_TRUE(made.ok());
  EXPECT_THAT(made->Record(VK_NULL_HANDLE, VulkanFrame()).message(), HasSubstr("command buffer"));
  const Result<VkCommandBuffer> commands = device_->Begin();
  ASSERT_TRUE(commands.ok());
  const auto without = [&](VulkanImage VulkanFrame::*image) {
    VulkanFrame frame = FrameOf(upload->inputs(), f);
    frame.*image = VulkanImage();
    return made->Record(*commands, frame).message();
  };
  EXPECT_EQ(without(&VulkanFrame::depth), "frame 4: image 'depth' is not given");
  EXPECT_EQ(without(&VulkanFrame::normal), "frame 4: image 'normal' is not given");
  EXPECT_EQ(without(&VulkanFrame::motion), "frame 4: image 'motion' is not given");
  EXPECT_EQ(without(&VulkanFrame::albedo), "frame 4: image 'albedo' is not given");
  EXPECT_EQ(without(&VulkanFrame::specular_albedo),
            "frame 4: image 'specular_albedo' is not given");
  EXPECT_EQ(without(&VulkanFrame::colour), "frame 4: image 'colour' is not given");
  VulkanFrame frame = FrameOf(upload->inputs(), f);
  frame.lights[4] = frame.lights[0];
  EXPECT_THAT(made->Record(*commands, frame).message(),
              HasSubstr("transmission signals are given, but the denoiser was made without"));
  frame = FrameOf(upload->inputs(), f);
  frame.jitter_x = 0.6f;
  EXPECT_EQ(made->Record(*commands, frame).message(),
            "frame 4: jitter is (0.6, 0.125), expected -0.5 to 0.5 for each");
  Settings by_position = made->settings();
  by_position.depth_weight = DepthWeight::kPosition;
  EXPECT_TRUE(made->SetSettings(by_position).ok());
  frame = FrameOf(upload->inputs(), f);
  frame.focal_pixels = 0;
  EXPECT_THAT(made->Record(*commands, frame).message(),
              HasSubstr("frame 4: depth_weight=position needs the focal length of the frame"));
  Settings other = made->settings();
  other.signals = SignalGrouping::kSingle;
  EXPECT_EQ(made->SetSettings(other).code(), StatusCode::kInvalidArgument);
  EXPECT_TRUE(device_->Run().ok());

  VulkanOptions o = options("default");
  o.width = 0;
  EXPECT_THAT(VulkanDenoiser::Create(context(), o).status().message(),
              HasSubstr("frames are 0x37"));
  EXPECT_THAT(VulkanDenoiser::MemoryNeed(context(), o).status().message(), HasSubstr("0x37"));
  EXPECT_THAT(VulkanDenoiser::Create({}, options("svgf")).status().message(),
              HasSubstr("get_instance_proc_addr must be given"));
}

TEST_F(Embedding, JitterTurnsAntialiasingInTimeOn) {
  const auto second = [&](float jitter, const char* antialias) {
    VulkanOptions o = options("default");
    EXPECT_TRUE(SetParameter(&o.settings, "antialias", antialias).ok());
    // Expects differences by jitter.
    EXPECT_TRUE(SetParameter(&o.settings, "limit_history", "off").ok());
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
    EXPECT_TRUE(made.ok()) << made.status().message();
    auto upload = Upload(device_->context(), MakeBusyFrame(kWidth, kHeight, 0));
    Image3 colour;
    for (int i = 0; i < 2; ++i) {
      const Frame f = MakeBusyFrame(kWidth, kHeight, i);
      RunFrame(device_.get(), upload.get(), f, &colour, [&](VkCommandBuffer commands) {
        VulkanFrame frame = FrameOf(upload->inputs(), f);
        frame.jitter_x = jitter;
        frame.jitter_y = 0;
        EXPECT_TRUE(made->Record(commands, frame).ok());
      });
    }
    return colour;
  };
  EXPECT_FALSE(test::SameBits(second(0.25f, "auto"), second(0, "auto")));
  ExpectSameBits(second(0.25f, "auto"), second(0, "taa"));
  ExpectSameBits(second(0, "auto"), second(0.25f, "off"));
}

TEST_F(Embedding, FramesThatDoNotFitAreAnError) {
  VulkanOptions o = options("default");
  o.width = o.height = 11000;  // each image is below 4 GB
  const Result<DeviceMemory> need = VulkanDenoiser::MemoryNeed(context(), o);
  ASSERT_TRUE(need.ok()) << need.status().message();
  if (need->bytes <= device_->info().memory_bytes) {
    GTEST_SKIP() << "this device has room for the largest frame";
  }
  const Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.status().code(), StatusCode::kOutOfMemory);
  EXPECT_THAT(made.status().message(), HasSubstr("MB, the device has"));
  o.width = static_cast<int>(device_->context().limits.maxImageDimension2D) + 1;
  EXPECT_THAT(VulkanDenoiser::Create(context(), o).status().message(), HasSubstr("on this device"));
}

TEST_F(Embedding, InC) {
  const Frame f = MakeBusyFrame(kWidth, kHeight, 0);
  auto upload = Upload(device_->context(), f);
  stillray_vulkan_context c = STILLRAY_VULKAN_CONTEXT_INIT;
  c.instance = instance_->handle();
  c.physical_device = device_->context().physical;
  c.device = device_->context().device;
  c.get_instance_proc_addr = instance_->get_instance_proc_addr();
  const char* changes[] = {"sigma_l=2", "antialias=off"};
  stillray_vulkan_options o = STILLRAY_VULKAN_OPTIONS_INIT;
  o.preset = "svgf";
  o.settings = changes;
  o.setting_count = 2;
  o.width = kWidth;
  o.height = kHeight;
  stillray_vulkan_memory need = STILLRAY_VULKAN_MEMORY_INIT;
  ASSERT_EQ(stillray_vulkan_memory_need(&c, &o, &need), STILLRAY_OK);
  EXPECT_GT(need.bytes, 0u);
  stillray_vulkan_denoiser* denoiser = nullptr;
  EXPECT_EQ(stillray_vulkan_create(99, &c, &o, &denoiser), STILLRAY_ERROR_UNSUPPORTED);
  ASSERT_EQ(stillray_vulkan_create(STILLRAY_ABI_VERSION, &c, &o, &denoiser), STILLRAY_OK)
      << stillray_vulkan_error_message(nullptr);
  const VulkanFrame cpp = FrameOf(upload->inputs(), f);
  stillray_vulkan_frame frame = CFrameOf(cpp);
  Image3 colour;
  RunFrame(device_.get(), upload.get(), f, &colour, [&](VkCommandBuffer commands) {
    EXPECT_EQ(stillray_vulkan_record(denoiser, commands, &frame), STILLRAY_OK)
        << stillray_vulkan_error_message(denoiser);
  });
  Denoiser host = MakeDenoiser(test::With("svgf", {{"sigma_l", "2"}, {"antialias", "off"}}),
                               DevicePrecision::kHalf);
  DenoisedFrame expected;
  ASSERT_TRUE(host.Denoise(f, &expected).ok());
  ExpectSameBits(colour, expected.colour);

  EXPECT_EQ(stillray_vulkan_set(denoiser, "sigma_l", "5"), STILLRAY_OK);
  EXPECT_EQ(stillray_vulkan_set(denoiser, "sigma_x", "5"), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_THAT(stillray_vulkan_error_message(denoiser), HasSubstr("sigma_x"));
  EXPECT_EQ(stillray_vulkan_record(denoiser, nullptr, nullptr), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_STREQ(stillray_vulkan_error_message(denoiser), "frame is NULL");
  frame.struct_size = 0;
  EXPECT_EQ(stillray_vulkan_record(denoiser, nullptr, &frame), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_STREQ(stillray_vulkan_error_message(denoiser),
               "frame->struct_size is 0, expected sizeof(stillray_vulkan_frame)");
  EXPECT_EQ(stillray_vulkan_reset(nullptr), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(stillray_vulkan_reset(denoiser), STILLRAY_OK);
  EXPECT_EQ(stillray_vulkan_forget_images(denoiser), STILLRAY_OK);
  stillray_vulkan_release(denoiser);
  stillray_vulkan_release(nullptr);
  o.preset = "none";
  EXPECT_EQ(stillray_vulkan_create(STILLRAY_ABI_VERSION, &c, &o, &denoiser),
            STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(denoiser, nullptr);
}

}  // namespace
}  // namespace stillray::embedding_test
