// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Rasterised triangles are the first hits of the camera's rays.
#include "render/vulkan/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "gpu/vulkan_test.h"
#include "render/deforming_scene.h"
#include "render/moment.h"
#include "render/test_scenes.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/gpu_batch.h"

namespace stillray::render {
namespace {

constexpr int kWidth = 211;
constexpr int kHeight = 97;
// The rasteriser rounds corners to a part of a pixel: so many of 10000 pixels, at edges, show their
// other side.
constexpr int kPerTenThousand = 50;

GpuView ToGpuView(const CameraView& view) {
  return {view.position, view.half_width,  view.right,        view.half_height,
          view.up,       view.width,       view.forward,      view.height,
          view.shift,    view.lens_radius, view.inverse_focus};
}

class GpuVisibilityTest : public test::VulkanTest {
 protected:
  struct Seen {
    uint32_t instance;
    uint32_t primitive;
  };

  // Reads the results of Record in `view`.
  std::vector<Seen> Draw(const GpuAccel& accel, const Visibility& visibility,
                         const RasterView& view) {
    gpu::Arena arena(&device_->context());
    const size_t bytes = visibility.triangles().size;
    const auto host = arena.AddBuffer(bytes, 0, gpu::BufferPlace::kDownload);
    EXPECT_TRUE(host.ok() && arena.Allocate().ok());
    const Result<VkCommandBuffer> commands = device_->Begin();
    EXPECT_TRUE(commands.ok());
    accel.RecordUpdate(*commands);
    visibility.Record(*commands, view);
    const gpu::DeviceContext& c = device_->context();
    gpu::MemoryBarrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                       VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
    const VkBufferCopy region = {0, 0, bytes};
    c.vk.CmdCopyBuffer(*commands, visibility.triangles().buffer, (*host)->buffer, 1, &region);
    gpu::MemoryBarrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                       VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
    EXPECT_TRUE(device_->Run().ok());
    EXPECT_TRUE(arena.Invalidate().ok());
    std::vector<Seen> seen(size_t{kWidth} * kHeight);
    std::memcpy(seen.data(), (*host)->mapped, seen.size() * sizeof(Seen));
    return seen;
  }

  // Through a point of the pixels that is not their centre, at two moments.
  void ExpectTheRays(const Scene& scene) {
    SceneState state(scene);
    state.Update(0.0, 0.0);
    const SceneShadowFilter filter(state);
    const auto embree = Accel::Create(scene, DescribeInstances(state), state.Places(), filter);
    const auto accel = GpuAccel::Create(device_.get(), state);
    ASSERT_TRUE(embree.ok() && accel.ok());
    // Room for more than is drawn.
    const auto visibility =
        Visibility::Create(device_.get(), accel->get(), state, kWidth + 13, kHeight + 5);
    ASSERT_TRUE(visibility.ok()) << visibility.status().message();
    ASSERT_TRUE((*visibility)->HasRoomFor(kWidth, kHeight));
    ASSERT_FALSE((*visibility)->HasRoomFor(kWidth + 14, kHeight));
    for (const double seconds : {0.0, 0.4}) {
      SCOPED_TRACE(seconds);
      state.Update(seconds, seconds);
      ASSERT_TRUE((*embree)->Update(state.Places()).ok());
      ASSERT_TRUE((*accel)->Update().ok());
      const vec2 point(0.8f, 0.15f);
      RenderMoment moment;
      moment.seconds = moment.previous_seconds = seconds;
      const CameraView view = CamerasOf(state, moment, kWidth, kHeight).now;
      const std::vector<Seen> seen = Draw(**accel, **visibility, {ToGpuView(view), point});
      std::vector<GpuRay> rays;
      for (int i = 0; i < kWidth * kHeight; ++i) {
        const vec2 pixel(static_cast<float>(i % kWidth), static_cast<float>(i / kWidth));
        rays.push_back({view.position, std::numeric_limits<float>::infinity(),
                        view.Direction(pixel + point), 0});
      }
      const std::vector<GpuHit> hits = EmbreeFirstHits(**embree, rays);
      int found = 0;
      int different = 0;
      for (size_t i = 0; i < rays.size(); ++i) {
        const bool hit = hits[i].instance != kNoHit;
        found += hit ? 1 : 0;
        const bool same =
            hit ? seen[i].instance == hits[i].instance && seen[i].primitive == hits[i].primitive
                : seen[i].instance == kNoInstance;
        different += same ? 0 : 1;
      }
      EXPECT_GT(found, kWidth * kHeight / 10);
      test::RecordLargest("different hits", different, kWidth * kHeight * kPerTenThousand / 10000);
      EXPECT_LE(different, kWidth * kHeight * kPerTenThousand / 10000);
    }
  }
};

TEST_F(GpuVisibilityTest, BuiltinScenes) {
  for (const std::string& name : BuiltinSceneNames()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    ExpectTheRays(*scene);
  }
}

TEST_F(GpuVisibilityTest, SeeThroughMirroredAndMoving) {
  ExpectTheRays(EverythingScene());
}

// Mesa's software driver takes time stamps late once it has drawn: see Timestamps::Mark.
TEST_F(GpuVisibilityTest, TimesOfRaysAreTrueAfterDrawing) {
  if (!device_->has_timestamps()) {
    GTEST_SKIP() << "the device measures no times";
  }
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  ASSERT_TRUE(scene.ok());
  SceneState state(*scene);
  state.Update(0, 0);
  const auto accel = GpuAccel::Create(device_.get(), state);
  ASSERT_TRUE(accel.ok());
  const std::vector<GpuRay> rays = RandomRays(SceneBounds(*scene, 0), 20000, 1);
  GpuBatch batch(device_.get(), accel->get(), static_cast<uint32_t>(rays.size()));
  const auto least_ms = [&] {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 5; ++i) {
      batch.FirstHits(rays);
      least = std::min(least, batch.milliseconds());
    }
    return least;
  };
  const double before = least_ms();
  const auto visibility = Visibility::Create(device_.get(), accel->get(), state, kWidth, kHeight);
  ASSERT_TRUE(visibility.ok()) << visibility.status().message();
  const CameraView view = CamerasOf(state, {}, kWidth, kHeight).now;
  Draw(**accel, **visibility, {ToGpuView(view), vec2(0.5f)});
  const double after = least_ms();
  ASSERT_TRUE(batch.status().ok()) << batch.status().message();
  EXPECT_GT(before, 0);
  EXPECT_GT(after, 0.2 * before);
  EXPECT_LT(after, 5 * before);
}

TEST_F(GpuVisibilityTest, Deforming) {
  ExpectTheRays(DeformingScene(10));
}

}  // namespace
}  // namespace stillray::render
