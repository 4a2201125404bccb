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

  static RenderMoment Moment(int64_t index) {
    RenderMoment moment;
    moment.frame_index = index;
    moment.seconds = static_cast<double>(index) / 10;
    moment.previous_seconds = moment.seconds - 0.1;
    return moment;
  }

  // Frame `index`, brought to the host.
  static Frame Render(int64_t index, Renderer* renderer) {
    Frame frame;
    const Status status = renderer->RenderFrame(Moment(index), &frame);
    EXPECT_TRUE(status.ok()) << status.message();
    EXPECT_EQ(frame.on_device != nullptr, renderer->settings().on_device);
    Frame room;
    const Result<const Frame*> host = OnHost(frame, &room);
    EXPECT_TRUE(host.ok()) << host.status().message();
    return **host;
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
        const Frame expected = Render(index, whole.get());
        for (size_t i = 0; i < renderers.size(); ++i) {
          SCOPED_TRACE(i);
          ExpectFrame(Render(index, renderers[i].get()), expected);
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

TEST_F(GpuSubmissionsTest, FreeMemoryIsAPartOfTheDevices) {
  const uint64_t free = gpu::FreeMemory(*device_);
  EXPECT_GT(free, uint64_t{1} << 24);
  EXPECT_LE(free, device_->info().memory_bytes);
}

}  // namespace
}  // namespace stillray::render
