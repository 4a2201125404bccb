// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Hit distances in a caller's own command buffers: the pictures of the guides that the host makes
// of them.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "gpu/embedded_renderer.h"
#include "stillray/reflections.h"
#include "stillray/vulkan.h"

namespace stillray::embedded_hits_test {
namespace {

using test::MakeMirrors;
using test::PutOnDevice;
using ::testing::HasSubstr;

using EmbeddedHits = test::EmbeddedRenderer;

/// Looks along -z; later frames stand further to the right, and are turned.
stillray_camera CameraOf(int index) {
  const double x = 0.03 * index;
  const double c = std::cos(0.01 * index);
  const double s = std::sin(0.01 * index);
  return {{c, 0, s, -c * x, 0, 1, 0, 0, -s, 0, c, s * x, 0, 0, 0, 1},
          {1.2, 0, 0, 0, 0, 1.6, 0, 0, 0, 0, -1.002, -0.2, 0, 0, -1, 0}};
}

CameraMatrices MatricesOfFrame(int index) {
  const stillray_camera camera = CameraOf(index);
  std::array<double, 16> to_camera{};
  std::array<double, 16> projection{};
  std::copy_n(camera.world_to_camera, 16, to_camera.begin());
  std::copy_n(camera.projection, 16, projection.begin());
  return MatricesOf(to_camera, projection);
}

int Before(int index) {
  return std::max(index - 1, 0);  // the first frame has none
}

/// Lengths of reflected rays: of few values, some of them of the sky or not known.
Image1 HitsOf(int width, int height, int index) {
  return test::MakePlane(width, height, [&](int x, int y) {
    const int block = (x + index) / 4 + y / 6;
    return block % 7 == 0   ? std::numeric_limits<float>::infinity()
           : block % 5 == 0 ? 0.0f
                            : 1.5f * static_cast<float>(block % 4) + 1;
  });
}

/// The frame with reflections from hit distances. \param bare  without normal, albedo and id
Frame WithHits(const Frame& frame, const Image1& hits, bool bare) {
  Frame f = frame;
  const int index = static_cast<int>(f.index);
  Result<VirtualGuides> made =
      ReflectionsFromHits(f.guides, hits, MatricesOfFrame(index), MatricesOfFrame(Before(index)));
  EXPECT_TRUE(made.ok()) << made.status().message();
  if (!bare) {
    made->normal = f.reflection.normal;
    made->albedo = f.reflection.albedo;
    made->id = f.reflection.id;
  }
  f.reflection = *made;
  return f;
}

TEST_F(EmbeddedHits, GiveThePicturesOfTheirGuides) {
  for (const bool bare : {false, true}) {
    SCOPED_TRACE(bare ? "the length alone" : "with normal, albedo and id");
    const Frame first = MakeMirrors(51, 37, 0, false);
    VulkanOptions options = Options(first, DevicePrecision::kFloat);
    const Result<DeviceMemory> without = VulkanDenoiser::MemoryNeed(context(), options);
    options.hit_distances = true;
    const Result<DeviceMemory> need = VulkanDenoiser::MemoryNeed(context(), options);
    ASSERT_TRUE(without.ok() && need.ok());
    EXPECT_GE(need->bytes, without->bytes + 12 * 51 * 37);
    EXPECT_EQ(need->resources, without->resources + 2);
    Result<VulkanDenoiser> embedded = VulkanDenoiser::Create(context(), options);
    ASSERT_TRUE(embedded.ok()) << embedded.status().message();
    EXPECT_EQ(embedded->memory().bytes, need->bytes);
    MakeOutput(first);
    Denoiser from_host = MakeDenoiser(options.settings, DevicePrecision::kFloat);
    Denoiser by_others = MakeDenoiser(options.settings, DevicePrecision::kFloat);
    double apart = 0;
    for (int index = 0; index < 4; ++index) {
      SCOPED_TRACE(index);
      Frame f = MakeMirrors(51, 37, index, false);
      const Image1 hits = HitsOf(f.width, f.height, index);
      DenoisedFrame expected;
      ASSERT_TRUE(from_host.Denoise(WithHits(f, hits, bare), &expected).ok());
      DenoisedFrame other;
      ASSERT_TRUE(by_others.Denoise(f, &other).ok());
      f.reflection.depth = hits;  // lies on the device in its place
      const Frame on_device = PutOnDevice(device_, f);
      VulkanFrame frame = FrameOf(f, on_device);
      std::swap(frame.hit_distance, frame.reflection.depth);
      frame.reflection.motion = {};
      if (bare) {
        frame.reflection = {};
      }
      frame.camera = MatricesOfFrame(index);
      frame.previous_camera = MatricesOfFrame(Before(index));
      Run([&](VkCommandBuffer commands) { return embedded->Record(commands, frame); });
      const Image3 found = Picture();
      if (device_->context().is_software) {
        EXPECT_TRUE(test::SameBits(found, expected.colour));
      } else {  // roots and quotients of GPUs are rounded otherwise
        test::ExpectImage({"colour", {found[0], found[1], found[2]}},
                          {"colour", {expected.colour[0], expected.colour[1], expected.colour[2]}},
                          test::RescaledMoments(*device_), "hit distances");
      }
      for (int y = 0; y < f.height; ++y) {
        for (int x = 0; x < f.width; ++x) {
          apart = std::max(apart, std::abs(static_cast<double>(expected.colour[0](x, y)) -
                                           other.colour[0](x, y)));
        }
      }
      ASSERT_TRUE(embedded->ForgetImages().ok());
    }
    EXPECT_GT(apart, 0.05);  // other guides give another picture
  }
}

TEST_F(EmbeddedHits, SayWhatIsWrong) {
  const Frame f = MakeMirrors(51, 37, 0, false);
  const Frame on_device = PutOnDevice(device_, f);
  VulkanOptions options = Options(f, DevicePrecision::kHalf);
  options.hit_distances = true;
  MakeOutput(f);
  const auto message = [&](VulkanDenoiser* denoiser, auto change) {
    VulkanFrame frame = FrameOf(f, on_device);
    std::swap(frame.hit_distance, frame.reflection.depth);
    frame.reflection.motion = {};
    frame.camera = frame.previous_camera = MatricesOfFrame(0);
    change(&frame);
    std::string text;
    Run([&](VkCommandBuffer commands) {
      text = denoiser->Record(commands, frame).message();
      return Status::Ok();
    });
    return text;
  };
  Result<VulkanDenoiser> with = VulkanDenoiser::Create(context(), options);
  ASSERT_TRUE(with.ok()) << with.status().message();
  EXPECT_EQ(message(&*with, [](VulkanFrame*) {}), "");
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->reflection.depth = v->depth; }),
              HasSubstr("image 'reflection.depth' is given beside 'hit_distance'"));
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->reflection.motion = v->motion; }),
              HasSubstr("image 'reflection.motion' is given beside 'hit_distance'"));
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->roughness = {}; }),
              HasSubstr("image 'roughness' is not given, beside 'hit_distance'"));
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->camera = {}; }),
              HasSubstr("frame 0: the camera of this frame has no inverse or no perspective"));
  EXPECT_THAT(message(&*with, [](VulkanFrame* v) { v->previous_camera = {}; }),
              HasSubstr("frame 0: the camera of the previous frame has no inverse"));
  options.hit_distances = false;
  Result<VulkanDenoiser> without = VulkanDenoiser::Create(context(), options);
  ASSERT_TRUE(without.ok());
  EXPECT_THAT(message(&*without, [](VulkanFrame*) {}),
              HasSubstr("image 'hit_distance' is given, but the denoiser was made without "
                        "hit_distances"));
  options.virtual_guides = false;
  options.hit_distances = true;
  EXPECT_THAT(VulkanDenoiser::Create(context(), options).status().message(),
              HasSubstr("hit_distances is set without virtual_guides"));
}

/// The images of a frame in C; the camera and the one before it are the caller's.
stillray_vulkan_frame InC(const VulkanFrame& f) {
  stillray_vulkan_frame frame = STILLRAY_VULKAN_FRAME_INIT;
  frame.index = f.index;
  frame.samples_per_pixel = f.samples_per_pixel;
  frame.jitter_x = f.jitter_x;
  frame.jitter_y = f.jitter_y;
  const auto set = [&](int slot, const VulkanImage& image) {
    frame.images[slot] = {image.view, image.layout};
  };
  for (int k = 0; k < kSignalKindCount; ++k) {
    set(STILLRAY_VULKAN_DIRECT_DIFFUSE + k, f.lights[k]);
    set(STILLRAY_VULKAN_SECOND_MOMENT + k, f.second_moments[k]);
  }
  set(STILLRAY_VULKAN_DEPTH, f.depth);
  set(STILLRAY_VULKAN_NORMAL, f.normal);
  set(STILLRAY_VULKAN_ID, f.id);
  set(STILLRAY_VULKAN_MOTION, f.motion);
  set(STILLRAY_VULKAN_ALBEDO, f.albedo);
  set(STILLRAY_VULKAN_SPECULAR_ALBEDO, f.specular_albedo);
  set(STILLRAY_VULKAN_EMISSION, f.emission);
  set(STILLRAY_VULKAN_BACKGROUND, f.background);
  set(STILLRAY_VULKAN_SAMPLES, f.samples);
  set(STILLRAY_VULKAN_ROUGHNESS, f.roughness);
  set(STILLRAY_VULKAN_PREVIOUS_NORMAL, f.previous_normal);
  set(STILLRAY_VULKAN_HIT_DISTANCE, f.hit_distance);
  set(STILLRAY_VULKAN_COLOUR, f.colour);
  return frame;
}

TEST_F(EmbeddedHits, InC) {
  const Frame first = MakeMirrors(51, 37, 0, false);
  MakeOutput(first);
  const VulkanContext given = context();
  stillray_vulkan_context c = STILLRAY_VULKAN_CONTEXT_INIT;
  c.instance = given.instance;
  c.physical_device = given.physical_device;
  c.device = given.device;
  c.get_instance_proc_addr = given.get_instance_proc_addr;
  stillray_vulkan_options o = STILLRAY_VULKAN_OPTIONS_INIT;
  o.width = 51;
  o.height = 37;
  o.virtual_guides = o.hit_distances = 1;
  stillray_vulkan_denoiser* in_c = nullptr;
  ASSERT_EQ(stillray_vulkan_create(STILLRAY_ABI_VERSION, &c, &o, &in_c), STILLRAY_OK)
      << stillray_vulkan_error_message(nullptr);
  VulkanOptions options = Options(first, DevicePrecision::kHalf);
  options.hit_distances = true;
  Result<VulkanDenoiser> in_cpp = VulkanDenoiser::Create(given, options);
  ASSERT_TRUE(in_cpp.ok()) << in_cpp.status().message();
  for (int index = 0; index < 3; ++index) {
    Frame f = MakeMirrors(51, 37, index, false);
    f.reflection.depth = HitsOf(f.width, f.height, index);
    const Frame on_device = PutOnDevice(device_, f);
    VulkanFrame frame = FrameOf(f, on_device);
    frame.hit_distance = frame.reflection.depth;
    frame.reflection = {};
    frame.camera = MatricesOfFrame(index);
    frame.previous_camera = MatricesOfFrame(Before(index));
    Run([&](VkCommandBuffer commands) { return in_cpp->Record(commands, frame); });
    const Image3 expected = Picture();
    stillray_vulkan_frame c_frame = InC(frame);
    const stillray_camera cameras[] = {CameraOf(index), CameraOf(Before(index))};
    Run([&](VkCommandBuffer commands) {
      EXPECT_EQ(stillray_vulkan_record(in_c, commands, &c_frame), STILLRAY_ERROR_INVALID_ARGUMENT);
      EXPECT_THAT(stillray_vulkan_error_message(in_c), HasSubstr("the camera of this frame"));
      c_frame.camera = &cameras[0];
      c_frame.previous_camera = &cameras[1];
      EXPECT_EQ(stillray_vulkan_record(in_c, commands, &c_frame), STILLRAY_OK)
          << stillray_vulkan_error_message(in_c);
      return Status::Ok();
    });
    EXPECT_TRUE(test::SameBits(Picture(), expected));
    ASSERT_TRUE(in_cpp->ForgetImages().ok());
    ASSERT_EQ(stillray_vulkan_forget_images(in_c), STILLRAY_OK);
  }
  stillray_vulkan_release(in_c);
}

}  // namespace
}  // namespace stillray::embedded_hits_test
