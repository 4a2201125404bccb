// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "benchmarks/ray_bench.h"

#include <cmath>

#include <gtest/gtest.h>

#include "stillray/scene.h"

namespace stillray::render::ray_bench_test {
namespace {

RenderSettings Small() {
  RenderSettings settings;
  settings.width = 96;
  settings.height = 54;
  settings.bounces = 2;
  settings.virtual_guides = false;  // as in the recorded frame
  return settings;
}

// Recording hands over every ray that the tracer counts, and every way to trace them finds the
// same: packets whose last lanes are empty, and streams that end early, among them.
TEST(RayBenchTest, EveryCallFindsTheSameInTheTracersRays) {
  for (const std::string& name : BuiltinSceneNames()) {
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    const RenderSettings settings = Small();
    RenderMoment moment;
    moment.frame_index = 1;
    Result<std::unique_ptr<RayBench>> bench = RayBench::Record(*scene, settings, moment);
    ASSERT_TRUE(bench.ok()) << bench.status().message();
    Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(*scene, settings);
    ASSERT_TRUE(renderer.ok());
    Frame frame;
    ASSERT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
    const RenderTimings& timings = (*renderer)->timings();
    const uint64_t expected[] = {timings.primary_rays, timings.bounce_rays, timings.shadow_rays};
    for (int p = 0; p < kRayPhaseCount; ++p) {
      const auto phase = static_cast<RayPhase>(p);
      EXPECT_EQ((*bench)->ray_count(phase), expected[p]) << name << " " << RayPhaseName(phase);
      const RayRun single = (*bench)->Run(phase, RayCall::kSingle);
      EXPECT_EQ(single.rays, expected[p]);
      EXPECT_GT(single.hits, 0u);
      EXPECT_LE(single.hits, single.rays);
      for (int c = 0; c < kRayCallCount; ++c) {
        const RayRun run = (*bench)->Run(phase, static_cast<RayCall>(c));
        EXPECT_EQ(run.rays, expected[p]);
        // The kernels round differently: rays along edges may hit with one and not with another.
        EXPECT_NEAR(static_cast<double>(run.hits), static_cast<double>(single.hits),
                    1.0 + 2e-3 * static_cast<double>(single.hits))
            << name << " " << RayPhaseName(phase) << " " << RayCallName(static_cast<RayCall>(c));
      }
    }
  }
}

TEST(RayBenchTest, TellsWhatIsWrongWithTheSettings) {
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  ASSERT_TRUE(scene.ok());
  RenderSettings settings = Small();
  settings.width = 0;
  EXPECT_FALSE(RayBench::Record(*scene, settings, RenderMoment()).ok());
}

}  // namespace
}  // namespace stillray::render::ray_bench_test
