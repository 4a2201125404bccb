// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames that stay on the device that traced them equal frames on the host, and are filtered to the
// same pictures.
#include "gpu/device_frame.h"

#include <gmock/gmock.h>

#include "denoise/vulkan/device_inputs.h"
#include "gpu/device_test.h"
#include "render/deforming_scene.h"
#include "render/vulkan/vulkan_renderer.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/expect_frame.h"
#include "render_gpu/moments.h"

namespace stillray::render {
namespace {

using ::testing::HasSubstr;

class DeviceFrameTest : public test::DeviceTest {
 protected:
  std::unique_ptr<Renderer> Create(const Scene& scene, const RenderSettings& settings) {
    auto renderer = CreateVulkanRenderer(scene, settings, device_);
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    return renderer.ok() ? std::move(*renderer) : nullptr;
  }

  static void Render(bool on_device, int64_t index, Renderer* renderer, Frame* frame) {
    RenderSettings settings = renderer->settings();
    settings.on_device = on_device;
    Status status = renderer->SetSettings(settings);
    ASSERT_TRUE(status.ok()) << status.message();
    status = renderer->RenderFrame(Moment(index), frame);
    ASSERT_TRUE(status.ok()) << status.message();
    ASSERT_EQ(frame->on_device != nullptr, on_device);
  }

  // Frames of the host and of the device, brought to the host, from one renderer.
  void ExpectSameFrames(const Scene& scene, const RenderSettings& settings, int frames) {
    const std::unique_ptr<Renderer> renderer = Create(scene, settings);
    ASSERT_NE(renderer, nullptr);
    Frame expected;
    Frame found;
    Frame room;
    for (int index = 3; index < 3 + frames; ++index) {
      SCOPED_TRACE(index);
      ASSERT_NO_FATAL_FAILURE(Render(false, index, renderer.get(), &expected));
      ASSERT_NO_FATAL_FAILURE(Render(true, index, renderer.get(), &found));
      EXPECT_TRUE(found.guides.depth.empty());
      EXPECT_TRUE(found.signals.front().radiance.empty());
      const Result<const Frame*> host = OnHost(found, &room);
      ASSERT_TRUE(host.ok()) << host.status().message();
      EXPECT_EQ((*host)->on_device, nullptr);
      ExpectFrame(**host, expected);
    }
  }

  // Pictures of frames that stay on the device, and of those that come from the host.
  void ExpectSamePictures(const Settings& settings, const RenderSettings& render, int frames,
                          const char* scene_name = "lights") {
    const Scene scene = MakeBuiltinScene(scene_name).value();
    const std::unique_ptr<Renderer> renderer = Create(scene, render);
    ASSERT_NE(renderer, nullptr);
    Denoiser from_host = MakeDenoiser(settings, DevicePrecision::kHalf);
    Denoiser stays = MakeDenoiser(settings, DevicePrecision::kHalf);
    Frame host;
    Frame turns[2];  // as render's files do, and images come and go
    for (int index = 1; index <= frames; ++index) {
      SCOPED_TRACE(index);
      Frame& frame = turns[index % 2];
      ASSERT_NO_FATAL_FAILURE(Render(false, index, renderer.get(), &host));
      ASSERT_NO_FATAL_FAILURE(Render(true, index, renderer.get(), &frame));
      DenoisedFrame expected;
      DenoisedFrame found;
      Status status = from_host.Denoise(host, &expected);
      ASSERT_TRUE(status.ok()) << status.message();
      status = stays.Denoise(frame, &found);
      ASSERT_TRUE(status.ok()) << status.message();
      ExpectPlanes(found.colour, expected.colour);
      EXPECT_EQ(found.bad_guides, expected.bad_guides);
      if (index % 4 == 0) {
        frame = Frame();
      }
    }
    EXPECT_LT(stays.memory_bytes(), from_host.memory_bytes());
  }
};

TEST_F(DeviceFrameTest, HoldsWhatFramesOnTheHostDo) {
  const Scene scene = EverythingScene();
  RenderSettings settings = SmallSettings(61, 37, 1);
  settings.jitter = true;
  ExpectSameFrames(scene, settings, 2);
}

TEST_F(DeviceFrameTest, HoldsSecondMomentsOfSeveralSamples) {
  ExpectSameFrames(EverythingScene(), SmallSettings(33, 17, 3), 2);
}

TEST_F(DeviceFrameTest, HoldsWhatSparseFramesDo) {
  const Scene scene = EverythingScene();
  for (const GuideCoverage guides : {GuideCoverage::kFull, GuideCoverage::kSparse}) {
    SCOPED_TRACE(guides == GuideCoverage::kFull ? "full guides" : "sparse guides");
    RenderSettings settings = SmallSettings(45, 27, 1);
    settings.cycle = 4;
    settings.guides = guides;
    ExpectSameFrames(scene, settings, 5);
  }
}

// A box with two faces in sight, which it turns by 36 degrees per frame, forth and back. It is far
// away: the depths of its points change by less than history_depth.
Scene TurningBox() {
  SceneBuilder builder;
  builder.scene.cameras[0].yfov = 0.1f;
  builder.Add(Quad(vec3(-9, -9, -60), vec3(18, 0, 0), vec3(0, 18, 0)), Lambert(vec3(0.5f)));
  const int box = builder.Add(BoxWithoutLids(1.5f), Metal(vec3(0.8f), 0.4f), At(vec3(0, 0, -40)));
  constexpr float kDegree = 0.0174532925f;
  std::vector<float> angles;
  for (int i = 0; i < 12; ++i) {
    angles.push_back((i % 2 == 0 ? 27 : 63) * kDegree);
  }
  builder.Turn(builder.InstanceNode(box), vec3(0, 1, 0), angles);
  builder.scene.environment.radiance = vec3(0.5f);
  return builder.scene;
}

TEST_F(DeviceFrameTest, HoldsPreviousNormals) {
  ExpectSameFrames(TurningBox(), SmallSettings(61, 37, 1), 2);
  RenderSettings settings = SmallSettings(45, 27, 1);
  settings.cycle = 4;
  settings.guides = GuideCoverage::kSparse;
  ExpectSameFrames(TurningBox(), settings, 2);
}

TEST_F(DeviceFrameTest, HoldsPreviousNormalsOfDeformingMeshes) {
  ExpectSameFrames(DeformingScene(10), SmallSettings(61, 37, 1), 2);
  RenderSettings settings = SmallSettings(45, 27, 1);
  settings.cycle = 4;
  settings.guides = GuideCoverage::kSparse;
  ExpectSameFrames(DeformingScene(10), settings, 2);
}

// The share of a box's pixels without a history, and its mean length.
struct Kept {
  double lost = 0;
  double length = 0;
};

Kept MeasureBox(const Frame& guides, const DenoisedFrame& out) {
  Kept kept;
  double pixels = 0;
  for (int y = 0; y < guides.height; ++y) {
    for (int x = 0; x < guides.width; ++x) {
      if (guides.guides.id(x, y) == 2) {
        pixels += 1;
        for (const NamedImage& image : out.images) {
          const double value = image.channels[0](x, y);
          (image.name == "disocclusion" ? kept.lost : kept.length) += value;
        }
      }
    }
  }
  EXPECT_GT(pixels, 500);
  return {kept.lost / pixels, kept.length / pixels};
}

TEST_F(DeviceFrameTest, ABoxThatTurnsKeepsItsHistory) {
  const Scene scene = TurningBox();
  const RenderSettings settings = SmallSettings(96, 54, 1);
  const std::unique_ptr<Renderer> on_device = Create(scene, settings);
  ASSERT_NE(on_device, nullptr);
  const std::unique_ptr<Renderer> on_host = std::move(Renderer::Create(scene, settings).value());
  Settings filter;
  filter.limit_history = false;  // the light of a face changes as it turns
  Denoiser by_device = MakeDenoiser(filter, DevicePrecision::kHalf);
  Denoiser by_cpu = std::move(Denoiser::Create(filter).value());
  Denoiser without = std::move(Denoiser::Create(filter).value());
  for (Denoiser* denoiser : {&by_device, &by_cpu, &without}) {
    ASSERT_TRUE(denoiser->SetOutputs({"disocclusion", "history.specular"}).ok());
  }
  Frame stays;
  Frame host;
  DenoisedFrame out;
  for (int i = 1; i <= 5; ++i) {
    SCOPED_TRACE(i);
    ASSERT_NO_FATAL_FAILURE(Render(true, i, on_device.get(), &stays));
    ASSERT_TRUE(on_host->RenderFrame(Moment(i), &host).ok());
    for (Denoiser* denoiser : {&by_device, &by_cpu}) {
      ASSERT_TRUE(denoiser->Denoise(denoiser == &by_device ? stays : host, &out).ok());
      const Kept kept = MeasureBox(host, out);
      if (i > 1) {
        EXPECT_LT(kept.lost, 0.1);
        EXPECT_GT(kept.length, 0.8 * i);
      }
    }
    host.guides.previous_normal = Image3();
    ASSERT_TRUE(without.Denoise(host, &out).ok());
    if (i > 1) {
      EXPECT_GT(MeasureBox(host, out).lost, 0.9);
    }
  }
}

TEST_F(DeviceFrameTest, OfASinglePixel) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  ExpectSameFrames(scene, SmallSettings(1, 1, 2), 1);
  RenderSettings settings = SmallSettings(1, 1, 1);
  settings.cycle = 4;  // three frames of which have no path at all
  settings.guides = GuideCoverage::kSparse;
  ExpectSameFrames(scene, settings, 4);
}

TEST_F(DeviceFrameTest, BringsWhatIsAskedFor) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  const std::unique_ptr<Renderer> renderer = Create(scene, SmallSettings(16, 9, 1));
  ASSERT_NE(renderer, nullptr);
  Frame frame;
  ASSERT_NO_FATAL_FAILURE(Render(true, 1, renderer.get(), &frame));
  EXPECT_GT(frame.on_device->bytes(), 16u * 9 * 100);
  Frame light;
  ASSERT_TRUE(frame.on_device->Download(kLightPlanes, &light).ok());
  EXPECT_EQ(light.signals.size(), 4u);
  EXPECT_EQ(light.emission.width(), 16);
  EXPECT_TRUE(light.guides.depth.empty());
  Frame guides;
  guides.samples = Image1(5, 5);  // not requested: unchanged
  ASSERT_TRUE(frame.on_device->Download(kGuidePlanes, &guides).ok());
  EXPECT_EQ(guides.guides.depth.height(), 9);
  EXPECT_TRUE(guides.emission.empty());
  EXPECT_EQ(guides.samples.width(), 5);
  ASSERT_TRUE(frame.on_device->Download(kAllPlanes, &guides).ok());
  EXPECT_TRUE(guides.samples.empty());
}

// Images are reused if there are no other references, and are unchanged if there are.
TEST_F(DeviceFrameTest, IsNotWrittenOverWhileItIsHeld) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  const std::unique_ptr<Renderer> renderer = Create(scene, SmallSettings(24, 16, 1));
  ASSERT_NE(renderer, nullptr);
  Frame frame;
  ASSERT_NO_FATAL_FAILURE(Render(true, 1, renderer.get(), &frame));
  const FrameOnDevice* const first = frame.on_device.get();
  ASSERT_NO_FATAL_FAILURE(Render(true, 2, renderer.get(), &frame));
  EXPECT_EQ(frame.on_device.get(), first);
  const Frame held = frame;
  Frame before;
  ASSERT_TRUE(OnHost(held, &before).ok());
  ASSERT_NO_FATAL_FAILURE(Render(true, 3, renderer.get(), &frame));
  EXPECT_NE(frame.on_device.get(), first);
  Frame after;
  ASSERT_TRUE(OnHost(held, &after).ok());
  ExpectFrame(after, before);
  // Frames of another size or kind get images of their own; those on the host none.
  RenderSettings settings = renderer->settings();
  settings.width = 40;
  ASSERT_TRUE(renderer->SetSettings(settings).ok());
  ASSERT_NO_FATAL_FAILURE(Render(true, 4, renderer.get(), &frame));
  EXPECT_EQ(gpu::FrameOn(*device_, frame)->shape().width, 40);
  ASSERT_NO_FATAL_FAILURE(Render(false, 4, renderer.get(), &frame));
  EXPECT_EQ(gpu::FrameOn(*device_, frame), nullptr);
}

TEST_F(DeviceFrameTest, ACancelledFrameIsLeftWithout) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  RenderSettings settings = SmallSettings(24, 16, 1);
  settings.on_device = true;
  const std::unique_ptr<Renderer> renderer = Create(scene, settings);
  ASSERT_NE(renderer, nullptr);
  Frame frame;
  const Status status = renderer->RenderFrame(Moment(1), &frame, [](double) { return false; });
  EXPECT_EQ(status.code(), StatusCode::kCancelled);
  EXPECT_EQ(frame.on_device, nullptr);
  Image3 reference;
  EXPECT_TRUE(renderer->RenderReference(Moment(1), 1, &reference).ok());
  EXPECT_TRUE(renderer->RenderFrame(Moment(1), &frame).ok());
  EXPECT_NE(frame.on_device, nullptr);
}

TEST_F(DeviceFrameTest, IsFilteredToTheSamePicture) {
  ExpectSamePictures(PresetSettings("svgf").value(), SmallSettings(61, 37, 1), 7);
}

TEST_F(DeviceFrameTest, IsFilteredToTheSamePictureWithSecondMoments) {
  ExpectSamePictures(PresetSettings("svgf").value(), SmallSettings(32, 19, 2), 3);
}

TEST_F(DeviceFrameTest, SparseOnesAreFilteredToTheSamePicture) {
  RenderSettings render = SmallSettings(61, 37, 1);
  render.cycle = 8;
  for (const GuideCoverage guides : {GuideCoverage::kFull, GuideCoverage::kSparse}) {
    render.guides = guides;
    ExpectSamePictures(PresetSettings("psvgf").value(), render, 9);
  }
}

// What mirrors and glass show has guides of its own, on the device as on the host. The camera
// moves.
TEST_F(DeviceFrameTest, WhatMirrorsShowIsFilteredToTheSamePicture) {
  RenderSettings render = SmallSettings(61, 37, 1);
  render.jitter = true;
  const Frame frame = RenderOne(MakeBuiltinScene("mirrors").value(), render, Moment(1));
  ASSERT_FALSE(frame.reflection.empty());
  ExpectSamePictures(Settings(), render, 7, "mirrors");
}

TEST_F(DeviceFrameTest, WhatMirrorsShowInSparseFramesIsFilteredToTheSamePicture) {
  RenderSettings render = SmallSettings(45, 27, 1);
  render.cycle = 4;
  ExpectSamePictures(Settings(), render, 5, "mirrors");
}

TEST_F(DeviceFrameTest, OtherDevicesBringItToTheHost) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  const std::unique_ptr<Renderer> renderer = Create(scene, SmallSettings(31, 18, 1));
  ASSERT_NE(renderer, nullptr);
  Frame host;
  Frame frame;
  ASSERT_NO_FATAL_FAILURE(Render(false, 1, renderer.get(), &host));
  ASSERT_NO_FATAL_FAILURE(Render(true, 1, renderer.get(), &frame));
  const Settings settings = PresetSettings("svgf").value();
  const auto expect_same = [&](Denoiser from_host, Denoiser from_device) {
    DenoisedFrame expected;
    DenoisedFrame found;
    ASSERT_TRUE(from_host.Denoise(host, &expected).ok());
    const Status status = from_device.Denoise(frame, &found);
    ASSERT_TRUE(status.ok()) << status.message();
    ExpectPlanes(found.colour, expected.colour);
  };
  {
    SCOPED_TRACE("the CPU");
    expect_same(Denoiser::Create(settings).value(), Denoiser::Create(settings).value());
  }
  SCOPED_TRACE("another device");
  Result<std::shared_ptr<gpu::Device>> other = gpu::Device::Create(instance_, device_->info());
  ASSERT_TRUE(other.ok()) << other.status().message();
  EXPECT_EQ(gpu::FrameOn(**other, frame), nullptr);
  const Device place = MakeDevice(std::make_shared<vulkan::VulkanBackend>(*other), "other");
  expect_same(MakeDenoiser(settings, DevicePrecision::kHalf),
              Denoiser::Create(settings, place).value());
}

TEST_F(DeviceFrameTest, GoesToTheHostWhereThereAreNoImagesForIt) {
  const auto most = device_->context().limits.maxImageDimension2D;
  if (most >= 32768) {
    GTEST_SKIP() << "the device's images are as large as pictures may be";
  }
  const Scene scene = MakeBuiltinScene("cornell").value();
  RenderSettings settings = SmallSettings(static_cast<int>(most) + 1, 1, 1);
  settings.on_device = true;
  settings.bounces = 1;
  const std::unique_ptr<Renderer> renderer = Create(scene, settings);
  ASSERT_NE(renderer, nullptr);
  Frame frame;
  const Status status = renderer->RenderFrame(Moment(1), &frame);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(frame.on_device, nullptr);
  EXPECT_EQ(frame.guides.depth.width(), settings.width);
  EXPECT_GT(frame.guides.depth(settings.width / 2, 0), 0);
}

TEST_F(DeviceFrameTest, WhatDoesNotFitIsRefused) {
  const int most = static_cast<int>(device_->context().limits.maxImageDimension2D);
  const auto create = [&](int width, int height) {
    return gpu::DeviceFrame::Create(device_, {width, height, true, true}).status();
  };
  EXPECT_EQ(create(most + 1, 1).code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(create(most + 1, 1).message(), HasSubstr("a frame on the device is "));
  EXPECT_EQ(create(1, 0).code(), StatusCode::kInvalidArgument);
  Frame lies;
  lies.on_device = gpu::DeviceFrame::Create(device_, {8, 8, false, false}).value();
  lies.width = 9;
  lies.height = 8;
  DenoisedFrame out;
  Denoiser denoiser = MakeDenoiser(PresetSettings("svgf").value(), DevicePrecision::kHalf);
  const Status status = denoiser.Denoise(lies, &out);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("size is 9x8, its images on the device are 8x8"));
}

// Sets made for images that are gone must be forgotten, whether or not handles come again.
TEST(SeenFrames, TellsWhenImagesAreGoneOrTooMany) {
  struct Pixels {};
  vulkan::SeenFrames seen;
  std::shared_ptr<const void> held[5];
  const auto add = [&](int first, size_t count = 1) { return seen.Add({held + first, count}); };
  for (auto& pixels : held) {
    pixels = std::make_shared<Pixels>();
  }
  EXPECT_FALSE(add(0));
  EXPECT_FALSE(add(1));
  EXPECT_FALSE(add(0));
  held[1] = std::make_shared<Pixels>();
  EXPECT_TRUE(add(0));
  EXPECT_FALSE(add(0));
  for (int i : {1, 2, 3}) {
    EXPECT_FALSE(add(i));
  }
  EXPECT_TRUE(add(4));
  EXPECT_FALSE(add(4));
  // Owners of one frame are remembered together, or the images of one would be forgotten while its
  // sets are kept.
  EXPECT_FALSE(add(2, 2));
  held[3] = nullptr;
  EXPECT_TRUE(add(2));
  EXPECT_FALSE(add(2));
  EXPECT_FALSE(add(0, 2));
  held[0] = nullptr;
  EXPECT_TRUE(add(1, 2));
  held[1] = nullptr;
  EXPECT_TRUE(add(2));
}

}  // namespace
}  // namespace stillray::render
