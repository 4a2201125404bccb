// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Guides that the device finds are those of the tracer on the CPU.
#include <gmock/gmock.h>

#include "render/deforming_scene.h"
#include "render/test_scenes.h"
#include "render/vulkan/vulkan_renderer.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/tracing_ways.h"

namespace stillray::render {
namespace {

constexpr int kWidth = 129;
constexpr int kHeight = 73;

// Of values near 1, and relative to larger ones. Directions of rays and hits agree to a few units
// in the last place; textures and reflectances at grazing angles multiply that.
constexpr double kTolerance = 1e-3;
// Pixels whose ray passes an edge may see its other side: so many in 10000.
constexpr int kPerTenThousand = 20;

double Off(double a, double b) {
  if (a == b) {
    return 0;  // infinities too
  }
  return std::isfinite(a) && std::isfinite(b) ? std::abs(a - b) / std::max(1.0, std::abs(b)) : 1e30;
}

// Guides do not depend on the paths, which take most of the time.
RenderSettings ShortPaths(int width, int height) {
  RenderSettings settings = SmallSettings(width, height, 1);
  settings.bounces = 1;
  settings.virtual_guides = false;  // gpu_virtual_guides_test.cpp
  return settings;
}

class GpuGuidesTest : public TracingWaysTest {
 protected:
  std::unique_ptr<Renderer> Create(const Scene& scene, int width, int height,
                                   bool rasterise = true) {
    VulkanRenderOptions options;
    options.first_hits = rasterise ? FirstHits::kDraw : FirstHits::kTrace;
    options.way = GetParam();
    auto renderer = CreateVulkanRenderer(scene, ShortPaths(width, height), device_, options);
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    return renderer.ok() ? std::move(*renderer) : nullptr;
  }

  // At rest, and moving.
  void ExpectTheCpus(const Scene& scene, bool rasterise) {
    SCOPED_TRACE(rasterise ? "drawn" : "traced");
    const std::unique_ptr<Renderer> renderer = Create(scene, kWidth, kHeight, rasterise);
    ASSERT_NE(renderer, nullptr);
    ExpectTheCpus(scene, renderer.get(), 0, 0);
    ExpectTheCpus(scene, renderer.get(), 0.7, 0.5);
  }

  void ExpectTheCpus(const Scene& scene, Renderer* renderer, double seconds,
                     double previous_seconds) {
    RenderMoment moment;
    moment.seconds = seconds;
    moment.previous_seconds = previous_seconds;
    const Frame frame = RenderOne(scene, ShortPaths(kWidth, kHeight), moment);
    Frame found;
    const Status status = renderer->RenderFrame(moment, &found);
    ASSERT_TRUE(status.ok()) << status.message();
    const Guides& g = found.guides;
    struct Count {
      const char* what;
      int wrong = 0;
    };
    Count depth{"depth"}, normal{"normal"}, albedo{"albedo"}, specular{"specular albedo"};
    Count emission{"emission"}, background{"background"}, motion{"motion"}, id{"id"},
        roughness{"roughness"}, previous{"previous normal"};
    int seen = 0;
    ASSERT_EQ(g.previous_normal.empty(), frame.guides.previous_normal.empty());
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Guides& e = frame.guides;
        seen += e.id(x, y) != 0 ? 1 : 0;
        double of_normal = 0, of_albedo = 0, of_specular = 0, of_emission = 0, of_background = 0;
        for (int k = 0; k < 3; ++k) {
          of_normal = std::max(of_normal, Off(g.normal[k](x, y), e.normal[k](x, y)));
          of_albedo = std::max(of_albedo, Off(g.albedo[k](x, y), e.albedo[k](x, y)));
          of_specular =
              std::max(of_specular, Off(g.specular_albedo[k](x, y), e.specular_albedo[k](x, y)));
          of_emission =
              std::max(of_emission, Off(found.emission[k](x, y), frame.emission[k](x, y)));
          of_background =
              std::max(of_background, Off(found.background[k](x, y), frame.background[k](x, y)));
        }
        const double of_motion = std::max(Off(g.motion[0](x, y), e.motion[0](x, y)),
                                          Off(g.motion[1](x, y), e.motion[1](x, y)));
        depth.wrong += Off(g.depth(x, y), e.depth(x, y)) > kTolerance ? 1 : 0;
        normal.wrong += of_normal > kTolerance ? 1 : 0;
        albedo.wrong += of_albedo > kTolerance ? 1 : 0;
        specular.wrong += of_specular > kTolerance ? 1 : 0;
        emission.wrong += of_emission > kTolerance ? 1 : 0;
        background.wrong += of_background > kTolerance ? 1 : 0;
        motion.wrong += of_motion > kTolerance ? 1 : 0;
        id.wrong += g.id(x, y) != e.id(x, y) ? 1 : 0;
        double of_previous = 0;
        for (int k = 0; k < 3 && !g.previous_normal.empty(); ++k) {
          of_previous =
              std::max(of_previous, Off(g.previous_normal[k](x, y), e.previous_normal[k](x, y)));
        }
        previous.wrong += of_previous > kTolerance ? 1 : 0;
        roughness.wrong += Off(g.roughness(x, y), e.roughness(x, y)) > kTolerance ? 1 : 0;
      }
    }
    EXPECT_GT(seen, kWidth * kHeight / 4);
    for (const Count& count :
         {depth, normal, albedo, specular, emission, background, motion, id, roughness, previous}) {
      test::RecordLargest(count.what, count.wrong, kWidth * kHeight * kPerTenThousand / 10000);
      EXPECT_LE(count.wrong, kWidth * kHeight * kPerTenThousand / 10000) << count.what;
    }
  }
};

TEST_P(GpuGuidesTest, OfTheBuiltinScenesAreTheCpus) {
  LeaveValidation();
  for (const std::string& name : ScenesToCompare()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    ExpectTheCpus(*scene, true);
  }
}

TEST_P(GpuGuidesTest, OfEverythingAreTheCpus) {
  ExpectTheCpus(EverythingScene(), false);
  ExpectTheCpus(EverythingScene(), true);
}

TEST_P(GpuGuidesTest, OfDeformingMeshesAreTheCpus) {
  ExpectTheCpus(DeformingScene(10), false);
  ExpectTheCpus(DeformingScene(10), true);
}

TEST_P(GpuGuidesTest, TinyPicturesAndNothingInSight) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(0.25f, 0.5f, 1);
  const std::unique_ptr<Renderer> renderer = Create(builder.scene, 2, 2);
  ASSERT_NE(renderer, nullptr);
  for (const auto& [width, height] : {std::pair{1, 1}, {9, 1}, {1, 17}}) {
    ASSERT_TRUE(renderer->SetSettings(SmallSettings(width, height, 1)).ok());
    Frame frame;
    ASSERT_TRUE(renderer->RenderFrame({}, &frame).ok());
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        EXPECT_EQ(frame.guides.id(x, y), 0u);
        EXPECT_EQ(frame.guides.depth(x, y), std::numeric_limits<float>::infinity());
        EXPECT_EQ(Pixel(frame.background, x, y), vec3(0.25f, 0.5f, 1));
        EXPECT_EQ(Pixel(frame.guides.normal, x, y), vec3(0.0f));
        EXPECT_NEAR(frame.guides.motion[0](x, y), 0.0f, 1e-5f);  // two views are rounded apart
        EXPECT_EQ(Pixel(frame.signals[0].radiance, x, y), vec3(0.0f));
      }
    }
  }
}

STILLRAY_IN_BOTH_WAYS(GpuGuidesTest);

}  // namespace
}  // namespace stillray::render
