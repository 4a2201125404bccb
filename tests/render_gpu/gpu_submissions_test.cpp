// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// How the path tracer on a device divides its work into batches and submissions changes no bit, and
// a frame that takes a short time is one submission.
#include <gtest/gtest.h>

#include "gpu/counted_calls.h"
#include "gpu/memory_budget.h"
#include "gpu/vulkan_test.h"
#include "render/vulkan/vulkan_renderer.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/expect_frame.h"
#include "render_gpu/moments.h"

namespace stillray::render {
namespace {

constexpr int kWidth = 73;
constexpr int kHeight = 45;
// Longer than anything takes on a software driver.
constexpr double kAnyTime = 1e9;

class GpuSubmissionsTest : public test::VulkanTest {
 protected:
  std::unique_ptr<Renderer> Create(const Scene& scene, const RenderSettings& settings,
                                   const VulkanRenderOptions& options) {
    auto renderer = CreateVulkanRenderer(scene, settings, device_, options);
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    return renderer.ok() ? std::move(*renderer) : nullptr;
  }

  static Frame Render(const RenderMoment& moment, Renderer* renderer) {
    Frame frame;
    const Status status = renderer->RenderFrame(moment, &frame);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(frame.on_device != nullptr, renderer->settings().on_device);
    return frame;
  }

  // Of frames on the host or the device.
  static void ExpectSame(const Frame& found, const Frame& expected) {
    Frame rooms[2];
    const Result<const Frame*> of_found = OnHost(found, &rooms[0]);
    const Result<const Frame*> of_expected = OnHost(expected, &rooms[1]);
    ASSERT_TRUE(of_found.ok()) << of_found.status().message();
    ASSERT_TRUE(of_expected.ok()) << of_expected.status().message();
    ExpectFrame(**of_found, **of_expected);
  }

  // Two frames of renderers with other batches and submissions.
  void ExpectSameBits(const Scene& scene, RenderSettings settings) {
    for (const bool on_device : {false, true}) {
      SCOPED_TRACE(on_device ? "on the device" : "on the host");
      settings.on_device = on_device;
      const std::unique_ptr<Renderer> whole = Create(scene, settings, {.submission_ms = kAnyTime});
      const VulkanRenderOptions others[] = {
          {.submission_ms = kAnyTime, .most_pixels = 1024},  // several batches, one submission
          {.submission_ms = kAnyTime, .most_pixels = 64},    // more than one submission has
          {.submission_ms = 1e-6},                           // the smallest submissions
      };
      std::vector<std::unique_ptr<Renderer>> renderers;
      for (const VulkanRenderOptions& options : others) {
        renderers.push_back(Create(scene, settings, options));
      }
      for (int64_t index = 4; index < 6; ++index) {
        const Frame expected = Render(Moment(index), whole.get());
        for (size_t i = 0; i < renderers.size(); ++i) {
          SCOPED_TRACE(i);
          ExpectSame(Render(Moment(index), renderers[i].get()), expected);
        }
      }
    }
  }
};

TEST_F(GpuSubmissionsTest, FramesOfAnyBatchesHaveTheSameBits) {
  ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false)));
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.jitter = true;
  ExpectSameBits(EverythingScene(), settings);
}

TEST_F(GpuSubmissionsTest, SamplesAndLensesOfAnyBatchesHaveTheSameBits) {
  ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false)));
  RenderSettings settings = SmallSettings(kWidth, kHeight, 3);
  settings.aperture = 0.1f;
  settings.bounces = 1;
  ExpectSameBits(EverythingScene(), settings);
}

TEST_F(GpuSubmissionsTest, FractionsOfASampleOfAnyBatchesHaveTheSameBits) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  for (const GuideCoverage guides : {GuideCoverage::kFull, GuideCoverage::kSparse}) {
    RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
    settings.cycle = 4;
    settings.guides = guides;
    ExpectSameBits(scene, settings);
  }
}

// The paths of a batch have the textures of its virtual images.
TEST_F(GpuSubmissionsTest, AveragedTexturesOfAnyBatchesHaveTheSameBits) {
  ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false)));
  const Scene scene = MakeBuiltinScene("mirrors").value();
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.jitter = true;
  settings.bounces = 1;
  for (const int cycle : {1, 4}) {
    settings.cycle = cycle;
    ExpectSameBits(scene, settings);
  }
}

TEST_F(GpuSubmissionsTest, ReferencesOfAnyBatchesHaveTheSameBits) {
  const Scene scene = MakeBuiltinScene("cornell").value();
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  Image3 expected;
  ASSERT_TRUE(Create(scene, settings, {.submission_ms = kAnyTime})
                  ->RenderReference(Moment(1), 3, &expected)
                  .ok());
  settings.on_device = true;  // references are on the host all the same
  Image3 found;
  ASSERT_TRUE(Create(scene, settings, {.submission_ms = 1e-6, .most_pixels = 1024})
                  ->RenderReference(Moment(1), 3, &found)
                  .ok());
  ExpectPlanes(found, expected);
}

// The first frame finds out how long the work takes; after that there is one submission, and one
// wait for it.
TEST_F(GpuSubmissionsTest, AShortFrameIsOneSubmission) {
  ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false)));
  UseNewDevice();
  const test::CountedCalls calls(device_.get());
  const Scene scene = MakeBuiltinScene("cornell").value();
  RenderSettings settings = SmallSettings(160, 128, 1);
  struct Case {
    const char* name;
    VulkanRenderOptions options;
    int cycle;
    bool on_device;
    int submissions;
  };
  const Case cases[] = {
      {"on the host", {.submission_ms = kAnyTime}, 1, false, 1},
      {"on the device", {.submission_ms = kAnyTime}, 1, true, 1},
      {"of three batches", {.submission_ms = kAnyTime, .most_pixels = 1 << 13}, 1, true, 1},
      {"of three batches on the host",
       {.submission_ms = kAnyTime, .most_pixels = 1 << 13},
       1,
       false,
       3},
      {"of a part of the pixels", {.submission_ms = kAnyTime}, 4, true, 1},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    settings.cycle = c.cycle;
    settings.on_device = c.on_device;
    const std::unique_ptr<Renderer> renderer = Create(scene, settings, c.options);
    Frame frame;
    calls.Take();
    ASSERT_TRUE(renderer->RenderFrame(Moment(0), &frame).ok());
    EXPECT_GT(calls.Take().submissions, 1);
    for (int64_t index = 1; index < 4; ++index) {
      ASSERT_TRUE(renderer->RenderFrame(Moment(index), &frame).ok());
      const test::CallCounts counts = calls.Take();
      EXPECT_EQ(counts.submissions, index > 1 ? c.submissions : counts.submissions);
      EXPECT_EQ(counts.waits, counts.submissions);
    }
  }
}

TEST_F(GpuSubmissionsTest, ALongFrameIsDivided) {
  ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false)));
  UseNewDevice();
  const test::CountedCalls calls(device_.get());
  const Scene scene = MakeBuiltinScene("cornell").value();
  const std::unique_ptr<Renderer> renderer =
      Create(scene, SmallSettings(80, 80, 2), {.submission_ms = 1e-6});
  Frame frame;
  std::vector<double> parts;
  ASSERT_TRUE(renderer->RenderFrame(Moment(0), &frame).ok());
  calls.Take();
  ASSERT_TRUE(renderer
                  ->RenderFrame(Moment(1), &frame,
                                [&](double part) {
                                  parts.push_back(part);
                                  return true;
                                })
                  .ok());
  // 6400 pixels, 2 samples, 2048 paths at a time.
  EXPECT_GE(calls.Take().submissions, 6);
  EXPECT_GE(parts.size(), 6u);
  EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end()));
  EXPECT_EQ(parts.back(), 1.0);
}

// Camera 0 looks along nine slabs of glass, at a lamp and a wall, camera 1 at the sky.
Scene GlassSlabs() {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  for (int i = 0; i < 9; ++i) {
    Material glass = Glass(1.5f, 0.0f);
    if (i == 4) {  // one of them scatters
      glass.attenuation_color = vec3(0.8f, 0.7f, 0.9f);
      glass.attenuation_distance = 2.0f;
      glass.multiscatter_color = vec3(0.6f, 0.5f, 0.4f);
    }
    const float z = -2.0f - 0.4f * static_cast<float>(i);
    builder.Add(Box(vec3(-0.7f, -0.5f, z - 0.2f), vec3(0.7f, 0.5f, z)), glass);
  }
  builder.Add(Quad(vec3(-3, -3, -8), vec3(6, 0, 0), vec3(0, 6, 0)), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(-1, 0, -7), vec3(1, 0, 0), vec3(0, 1, 0)), Emitter(vec3(5, 4, 3)));
  Transform back;
  back.rotation = Rotation(vec3(0, 1, 0), 3.14159265f);
  builder.scene.cameras.push_back({"sky", builder.AddNode(back), 0.3f, 0.0f});
  return builder.scene;
}

RenderMoment MomentOf(int camera, int64_t index) {
  RenderMoment moment;
  moment.camera = camera;
  moment.frame_index = index;
  return moment;
}

// As many steps are recorded as the frame before had. Where the camera suddenly shows longer paths,
// what is left follows in a second submission.
TEST_F(GpuSubmissionsTest, PathsLongerThanThoseOfTheLastFrameAreResumed) {
  ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false)));
  UseNewDevice();
  const test::CountedCalls calls(device_.get());
  const Scene scene = GlassSlabs();
  struct Case {
    const char* name;
    int spp;
    bool virtual_guides;  // with them transmitted light is separate: two paths for a pixel
    float aperture;
    uint32_t most_pixels;
  };
  const Case cases[] = {{"a sample", 1, false, 0.0f, 0},
                        {"two parts of a sample", 1, true, 0.0f, 0},
                        {"two parts of three samples", 3, true, 0.0f, 0},
                        {"three samples through a lens", 3, false, 0.02f, 0},
                        {"batches of two samples", 2, true, 0.0f, 512}};
  for (const Case& c : cases) {
    for (const bool on_device : {false, true}) {
      SCOPED_TRACE(std::string(c.name) + (on_device ? " on the device" : " on the host"));
      RenderSettings settings = SmallSettings(40, 30, c.spp);
      settings.virtual_guides = c.virtual_guides;
      settings.aperture = c.aperture;
      settings.focus = 4.0f;
      settings.on_device = on_device;
      const VulkanRenderOptions options = {.submission_ms = kAnyTime, .most_pixels = c.most_pixels};
      const std::unique_ptr<Renderer> renderer = Create(scene, settings, options);
      const std::unique_ptr<Renderer> fresh = Create(scene, settings, options);
      Render(MomentOf(1, 3), renderer.get());
      calls.Take();
      const Frame frame = Render(MomentOf(0, 4), renderer.get());
      const int submissions = calls.Take().submissions;
      EXPECT_GT(submissions, 1);
      EXPECT_TRUE(!on_device || submissions == 2) << submissions;
      const Frame expected = Render(MomentOf(0, 4), fresh.get());
      EXPECT_LT(calls.Take().submissions, submissions);
      ExpectSame(frame, expected);
      EXPECT_EQ(renderer->timings().bounce_rays, fresh->timings().bounce_rays);
      EXPECT_EQ(renderer->timings().shadow_rays, fresh->timings().shadow_rays);
      EXPECT_EQ(renderer->timings().primary_rays, fresh->timings().primary_rays);
      EXPECT_EQ(renderer->timings().image_rays, fresh->timings().image_rays);
    }
  }
}

// Likewise, with the validation layer, and in hardware where there is any.
TEST_F(GpuSubmissionsTest, ResumingIsValid) {
  const Scene scene = GlassSlabs();
  RenderSettings settings = SmallSettings(24, 16, 2);
  settings.bounces = 1;
  settings.on_device = true;
  for (const TracingWay way : {TracingWay::kCompute, TracingWay::kHardware}) {
    if (way == TracingWay::kHardware && !device_->context().ray_tracing.offered) {
      continue;
    }
    const VulkanRenderOptions options = {.way = way, .submission_ms = kAnyTime, .most_pixels = 256};
    const std::unique_ptr<Renderer> renderer = Create(scene, settings, options);
    Render(MomentOf(1, 3), renderer.get());
    const Frame found = Render(MomentOf(0, 4), renderer.get());
    ExpectSame(found, Render(MomentOf(0, 4), Create(scene, settings, options).get()));
  }
}

// Commands of frames of one sample that stay on the device: 4 dispatches for a step, 3 for the last
// one.
TEST_F(GpuSubmissionsTest, StepsWithoutPathsAreNotRecorded) {
  ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false)));
  UseNewDevice();
  const test::CountedCalls calls(device_.get());
  const Scene cornell = MakeBuiltinScene("cornell").value();
  SceneBuilder pane;
  pane.scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  Material thin = Glass(1.5f, 0.0f);
  thin.solid = false;
  pane.Add(Quad(vec3(-2, -1, -4), vec3(4, 0, 0), vec3(0, 4, 0)), thin);
  pane.Add(Quad(vec3(-9, -1, 0), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  // Guides, the start of the paths, and what stores guides and light; cornell may turn, and has
  // previous normals too.
  constexpr int kOther = 7;
  constexpr int kOtherBarriers = 12;
  RenderSettings settings = SmallSettings(40, 30, 1);
  settings.bounces = 3;
  settings.on_device = true;
  settings.virtual_guides = false;
  const auto expect_steps = [&](int64_t index, int least, int most, int others,
                                Renderer* renderer) {
    calls.Take();
    Render(MomentOf(0, index), renderer);
    const test::CallCounts counts = calls.Take();
    const int steps = (counts.dispatches + 1 - others) / 4;
    EXPECT_EQ(counts.submissions, 1);
    EXPECT_EQ(counts.dispatches, 4 * steps - 1 + others);
    // The first frame waits for the scene's copy too.
    EXPECT_EQ(counts.barriers, 3 * steps + kOtherBarriers + (index == 0 ? 4 : 0));
    RecordProperty("steps of a frame", steps);
    EXPECT_GE(steps, least);
    EXPECT_LE(steps, most);
  };
  const std::unique_ptr<Renderer> opaque = Create(cornell, settings, {.submission_ms = kAnyTime});
  const std::unique_ptr<Renderer> glass = Create(pane.scene, settings, {.submission_ms = kAnyTime});
  for (int64_t index = 0; index < 3; ++index) {
    SCOPED_TRACE(index);
    expect_steps(index, 5, 5, kOther + 1, opaque.get());
    if (index == 0) {
      expect_steps(index, 29, 29, kOther, glass.get());
    } else {
      expect_steps(index, 6, 6, kOther, glass.get());
    }
  }
}

TEST_F(GpuSubmissionsTest, FreeMemoryIsAPartOfTheDevices) {
  const uint64_t free = gpu::FreeMemory(*device_);
  EXPECT_GT(free, uint64_t{1} << 24);
  EXPECT_LE(free, device_->info().memory_bytes);
  RecordProperty("megabytes", static_cast<int>(free >> 20));
}

}  // namespace
}  // namespace stillray::render
