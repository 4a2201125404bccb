// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Frames of the path tracer on a device are those of the one on the CPU, noise included.
#include "render/vulkan/vulkan_renderer.h"

#include <gmock/gmock.h>

#include "gpu/shared_pipelines.h"
#include "render/deforming_scene.h"
#include "render/test_scenes.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/moments.h"
#include "render_gpu/tracing_ways.h"

namespace stillray::render {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 73;
constexpr int kHeight = 45;

// A pixel's light may differ by so much, of itself and of the picture's mean.
constexpr double kTolerance = 2e-3;
// Where a rounding decides between two lights, two lobes or two sides of an edge, a path takes
// another way, and with it all that comes after: such pixels in a frame, per sample, in a thousand.
constexpr double kPerThousand = 8;

class GpuRendererTest : public TracingWaysTest {
 protected:
  std::unique_ptr<Renderer> Create(const Scene& scene, const RenderSettings& settings) {
    auto renderer = CreateVulkanRenderer(scene, settings, device_, {.way = GetParam()});
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    return renderer.ok() ? std::move(*renderer) : nullptr;
  }

  static std::unique_ptr<Renderer> CreateOnCpu(const Scene& scene, const RenderSettings& settings) {
    auto renderer = Renderer::Create(scene, settings);
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    return renderer.ok() ? std::move(*renderer) : nullptr;
  }

  static void ExpectFew(double differing, double most) {
    test::RecordLargest("differing pixels per thousand", differing, most);
    EXPECT_LE(differing, most);
  }

  // Pixels whose light is another, in a thousand; the picture's means must be close in any case.
  static double Differing(const Frame& found, const Frame& expected) {
    const Image3 sum = SumOfLight(expected);
    const double mean = Luminance709(Mean(sum));
    int wrong = 0;
    for (int y = 0; y < expected.height; ++y) {
      for (int x = 0; x < expected.width; ++x) {
        bool differs = false;
        for (size_t k = 0; k < expected.signals.size(); ++k) {
          const vec3 f = Pixel(found.signals[k].radiance, x, y);
          const vec3 e = Pixel(expected.signals[k].radiance, x, y);
          const double bound = kTolerance * (mean + MaxComponent(e));
          differs = differs || !(MaxComponent(abs(f - e)) <= bound);
          if (!expected.signals[k].second_moment.empty()) {
            const double s = found.signals[k].second_moment(x, y);
            const double t = expected.signals[k].second_moment(x, y);
            differs = differs || !(std::abs(s - t) <= 4 * kTolerance * (mean * mean + t));
          }
        }
        wrong += differs ? 1 : 0;
      }
    }
    return 1000.0 * wrong / (expected.width * expected.height);
  }

  // Depth, albedo and motion.
  void ExpectSameGuides(const Scene& scene, const RenderSettings& settings) {
    Frame found;
    Frame expected;
    ASSERT_TRUE(Create(scene, settings)->RenderFrame(Moment(3), &found).ok());
    ASSERT_TRUE(CreateOnCpu(scene, settings)->RenderFrame(Moment(3), &expected).ok());
    int wrong = 0;
    for (int y = 0; y < settings.height; ++y) {
      for (int x = 0; x < settings.width; ++x) {
        const float depth = expected.guides.depth(x, y);
        const float other = found.guides.depth(x, y);
        bool same = depth == other || std::abs(depth - other) <= 1e-3f * depth;
        same = same && MaxComponent(abs(Pixel(found.guides.albedo, x, y) -
                                        Pixel(expected.guides.albedo, x, y))) < 2e-3f;
        same = same &&
               std::abs(found.guides.motion[0](x, y) - expected.guides.motion[0](x, y)) < 1e-2f;
        wrong += same ? 0 : 1;
      }
    }
    EXPECT_LE(wrong, settings.width * settings.height / 100);
  }

  // Frames `first` and the one after.
  void ExpectTheCpus(const Scene& scene, const RenderSettings& settings, int64_t first,
                     double per_thousand) {
    const std::unique_ptr<Renderer> device = Create(scene, settings);
    const std::unique_ptr<Renderer> cpu = CreateOnCpu(scene, settings);
    ASSERT_TRUE(device != nullptr && cpu != nullptr);
    for (int64_t index = first; index < first + 2; ++index) {
      SCOPED_TRACE(index);
      Frame found;
      Frame expected;
      const Status status = device->RenderFrame(Moment(index), &found);
      ASSERT_TRUE(status.ok()) << status.message();
      ASSERT_TRUE(cpu->RenderFrame(Moment(index), &expected).ok());
      ExpectFew(Differing(found, expected), per_thousand);
      EXPECT_EQ(found.jitter_x, expected.jitter_x);
      EXPECT_EQ(found.focal_pixels, expected.focal_pixels);
      EXPECT_EQ(found.index, expected.index);
      ASSERT_EQ(found.samples.empty(), expected.samples.empty());
      for (int y = 0; y < expected.height && !expected.samples.empty(); ++y) {
        for (int x = 0; x < expected.width; ++x) {
          ASSERT_EQ(found.samples(x, y), expected.samples(x, y)) << x << " " << y;
        }
      }
      EXPECT_EQ(device->timings().dropped, 0u);
      const auto near = [](uint64_t f, uint64_t e) {
        EXPECT_NEAR(static_cast<double>(f), static_cast<double>(e),
                    0.01 * static_cast<double>(e) + 1);
      };
      // The device follows camera rays that pass several surfaces once more for their paths.
      EXPECT_GE(device->timings().primary_rays, cpu->timings().primary_rays);
      EXPECT_LE(device->timings().primary_rays, 3 * cpu->timings().primary_rays / 2);
      near(device->timings().bounce_rays, cpu->timings().bounce_rays);
      near(device->timings().shadow_rays, cpu->timings().shadow_rays);
    }
  }
};

TEST_P(GpuRendererTest, FramesOfTheBuiltinScenesAreTheCpus) {
  LeaveValidation();
  for (const std::string& name : ScenesToCompare()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
    settings.jitter = true;
    settings.virtual_guides = false;  // gpu_virtual_guides_test.cpp
    ExpectTheCpus(*scene, settings, 12, kPerThousand);
  }
}

TEST_P(GpuRendererTest, FramesOfEverythingAreTheCpus) {
  Scene scene = EverythingScene();
  scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  ExpectTheCpus(scene, SmallSettings(kWidth, kHeight, 1), 3, kPerThousand);
}

TEST_P(GpuRendererTest, FramesOfDeformingScenesAreTheCpus) {
  ExpectTheCpus(DeformingScene(10), SmallSettings(kWidth, kHeight, 1), 2, kPerThousand);
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.aperture = 0.1f;
  ExpectTheCpus(DeformingScene(60), settings, 3, 2 * kPerThousand);
  ExpectSameGuides(DeformingScene(10), settings);
}

TEST_P(GpuRendererTest, EveryLayeredMaterialIsTheCpus) {
  LeaveValidation();
  for (size_t i = 0; i < LayeredMaterials().size(); ++i) {
    SCOPED_TRACE(i);
    SceneBuilder builder;
    builder.scene.textures = EverythingTextures();
    builder.scene.cameras[0].yfov = 0.5f;
    builder.scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
    builder.Add(TexturedSphere(vec3(0, 0, -4), 1.0f, 3), LayeredMaterials()[i]);
    builder.Add(Quad(vec3(-9, -1, 0), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
    builder.Add(Quad(vec3(-1, 3, -4), vec3(2, 0, 0), vec3(0, 0, 2)), Emitter(vec3(5, 4, 3)));
    RenderSettings settings = SmallSettings(40, 30, 2);  // no ray meets an edge of the faces
    settings.regularise = i % 2 == 1;
    ExpectTheCpus(builder.scene, settings, 3, 2 * kPerThousand);
  }
}

TEST_P(GpuRendererTest, ManySamplesBouncesAndSettings) {
  LeaveValidation();
  const Result<Scene> scene = MakeBuiltinScene("spheres");
  RenderSettings settings = SmallSettings(48, 27, 2);
  settings.bounces = 6;
  settings.regularise = true;
  settings.seed = 0x123456789abcdefull;
  ExpectTheCpus(*scene, settings, 2, 2 * 2 * kPerThousand);
  settings.sampler = SamplerKind::kHalton16;
  settings.bounces = 1;
  settings.spp = 2;
  ExpectTheCpus(*scene, settings, 30, 2 * kPerThousand);
  // A sample number beyond the first sequence of the sampler.
  settings.sampler = SamplerKind::kSobol;
  ExpectTheCpus(*scene, settings, int64_t{1} << 33, 2 * kPerThousand);
}

// An area light, a point light and the environment over a matte floor and a mirror.
TEST_P(GpuRendererTest, EveryWayOfLightSamplingIsTheCpus) {
  LeaveValidation();
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  builder.Add(Quad(vec3(-4, -1, -1), vec3(8, 0, 0), vec3(0, 0, -8)), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(-2, -1, -4), vec3(2, 0, 0), vec3(0, 2, 0)), Metal(vec3(0.9f), 0.0f));
  builder.Add(Quad(vec3(-1, 2, -3), vec3(0, 0, -2), vec3(2, 0, 0)), Emitter(vec3(5, 4, 3)));
  PunctualLight lamp;
  lamp.node = builder.AddNode(At(vec3(2, 1, -3)));
  lamp.intensity = vec3(2.0f);
  builder.scene.lights.push_back(lamp);
  RenderSettings settings = SmallSettings(40, 30, 2);
  const std::unique_ptr<Renderer> device = Create(builder.scene, settings);
  const std::unique_ptr<Renderer> cpu = CreateOnCpu(builder.scene, settings);
  ASSERT_TRUE(device != nullptr && cpu != nullptr);
  const auto expect_the_cpus = [&] {
    Frame found;
    Frame expected;
    ASSERT_TRUE(device->SetSettings(settings).ok());
    ASSERT_TRUE(cpu->SetSettings(settings).ok());
    ASSERT_TRUE(device->RenderFrame(Moment(3), &found).ok());
    ASSERT_TRUE(cpu->RenderFrame(Moment(3), &expected).ok());
    EXPECT_LE(Differing(found, expected), 2 * kPerThousand);
    EXPECT_NEAR(static_cast<double>(device->timings().shadow_rays),
                static_cast<double>(cpu->timings().shadow_rays),
                0.01 * static_cast<double>(cpu->timings().shadow_rays));
  };
  for (const LightSampling sampling :
       {LightSampling::kNone, LightSampling::kBsdf, LightSampling::kLight}) {
    SCOPED_TRACE(static_cast<int>(sampling));
    settings.light_sampling = sampling;
    expect_the_cpus();
  }
  settings.light_sampling = LightSampling::kMis;
  settings.light_candidates = 1;
  expect_the_cpus();
  settings.light_candidates = 7;
  settings.clamp_radiance = 0.25f;
  expect_the_cpus();
}

TEST_P(GpuRendererTest, FractionsOfASamplePickTheCpusPixels) {
  const Result<Scene> scene = MakeBuiltinScene("lights");
  for (const GuideCoverage guides : {GuideCoverage::kFull, GuideCoverage::kSparse}) {
    RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
    settings.cycle = 8;
    settings.guides = guides;
    ExpectTheCpus(*scene, settings, 21, kPerThousand);
  }
}

TEST_P(GpuRendererTest, GuidesOfSparseFramesAreWhereThePathsAre) {
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.cycle = 4;
  settings.guides = GuideCoverage::kSparse;
  const std::unique_ptr<Renderer> device = Create(*scene, settings);
  Frame frame;
  for (int64_t index = 0; index < 3; ++index) {
    ASSERT_TRUE(device->RenderFrame(Moment(index), &frame).ok());
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(frame.guides.depth(x, y) != 0.0f, frame.samples(x, y) == 1.0f) << x << " " << y;
      }
    }
  }
}

// A lens: polygons, masks, both samplers, several samples with guides of their own, a focus that
// is found by itself.
TEST_P(GpuRendererTest, FramesThroughALensAreTheCpus) {
  LeaveValidation();
  Scene scene = EverythingScene();
  scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.aperture = 0.15f;
  settings.blades = 5;
  settings.blade_rotation = 20.0f;
  ExpectTheCpus(scene, settings, 3, 2 * kPerThousand);
  settings.spp = 3;
  settings.sampler = SamplerKind::kHalton16;
  ExpectTheCpus(scene, settings, 3, 4 * kPerThousand);
  ExpectSameGuides(scene, settings);
  settings = SmallSettings(kWidth, kHeight, 1);
  scene.cameras[0].lens.radius = 0.1f;
  scene.cameras[0].lens.focus = 5.0f;
  scene.cameras[0].lens.mask = 1;
  ExpectTheCpus(scene, settings, 3, 2 * kPerThousand);
  settings.cycle = 4;
  ExpectTheCpus(scene, settings, 3, 2 * kPerThousand);
}

TEST_P(GpuRendererTest, ALensMayBePutOnAndTakenOff) {
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  RenderSettings settings = SmallSettings(40, 30, 2);
  const std::unique_ptr<Renderer> device = Create(*scene, settings);
  for (const float aperture : {0.0f, 0.2f, 0.0f}) {
    settings.aperture = aperture;
    ASSERT_TRUE(device->SetSettings(settings).ok());
    Frame found;
    Frame expected;
    ASSERT_TRUE(device->RenderFrame(Moment(3), &found).ok());
    ASSERT_TRUE(CreateOnCpu(*scene, settings)->RenderFrame(Moment(3), &expected).ok());
    ExpectFew(Differing(found, expected), 2 * 2 * kPerThousand);
  }
}

// Both estimate the same picture with the same random numbers; the remaining differences are single
// paths that rounding sent another way.
TEST_P(GpuRendererTest, ConvergesToTheCpusPicture) {
  LeaveValidation();
  constexpr int kSpp = 8;
  for (const std::string& name : BuiltinSceneNames()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    RenderSettings settings = SmallSettings(24, 16, 1);
    settings.jitter = true;
    const std::unique_ptr<Renderer> device = Create(*scene, settings);
    const std::unique_ptr<Renderer> cpu = CreateOnCpu(*scene, settings);
    Image3 found;
    Image3 same;
    Image3 other;
    ASSERT_TRUE(device->RenderReference(Moment(5), kSpp, &found).ok());
    ASSERT_TRUE(cpu->RenderReference(Moment(5), kSpp, &same).ok());
    settings.seed = 7;
    ASSERT_TRUE(CreateOnCpu(*scene, settings)->RenderReference(Moment(5), kSpp, &other).ok());
    // The noise of such a picture, from two that are independent of each other.
    double noise = 0;
    double difference = 0;
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 24; ++x) {
        const double s = Luminance709(Pixel(same, x, y));
        const double n = Luminance709(Pixel(other, x, y)) - s;
        const double d = Luminance709(Pixel(found, x, y)) - s;
        noise += n * n / 2;
        difference += d * d;
      }
    }
    EXPECT_GT(noise, 0);
    EXPECT_LT(difference, 0.05 * noise);
    const double mean = Luminance709(Mean(same));
    EXPECT_NEAR(Luminance709(Mean(found)), mean, 1e-3 * mean);
  }
}

// Beyond the cycle of 16 samples both go on with the same new points, and references of any sampler
// with those of Sobol'.
TEST_P(GpuRendererTest, ManySamplesOfTheHaltonSamplerAreTheCpus) {
  LeaveValidation();
  constexpr int kSpp = 20;
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  RenderSettings settings = SmallSettings(16, 16, kSpp);
  settings.sampler = SamplerKind::kHalton16;
  Frame found;
  Frame same;
  ASSERT_TRUE(Create(*scene, settings)->RenderFrame(Moment(0), &found).ok());
  ASSERT_TRUE(CreateOnCpu(*scene, settings)->RenderFrame(Moment(0), &same).ok());
  const auto direct = static_cast<size_t>(SignalKind::kDirectDiffuse);
  const double mean = Luminance709(Mean(same.signals[direct].radiance));
  EXPECT_NEAR(Luminance709(Mean(found.signals[direct].radiance)), mean, 1e-3 * mean);
  Image3 reference;
  Image3 sobol;
  ASSERT_TRUE(Create(*scene, settings)->RenderReference(Moment(0), kSpp, &reference).ok());
  settings.sampler = SamplerKind::kSobol;
  ASSERT_TRUE(Create(*scene, settings)->RenderReference(Moment(0), kSpp, &sobol).ok());
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < reference.height(); ++y) {
      for (int x = 0; x < reference.width(); ++x) {
        ASSERT_EQ(reference[c](x, y), sobol[c](x, y)) << x << ' ' << y;
      }
    }
  }
}

// With random numbers of its own the mean over the picture is the CPU's within its standard error.
TEST_P(GpuRendererTest, MeansAgreeWithinNoise) {
  LeaveValidation();
  constexpr int kSpp = 16;
  Scene scene = EverythingScene();
  scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  const int size = 24;
  RenderSettings settings = SmallSettings(size, size, 1);
  settings.seed = 91;
  Image3 found;
  Image3 expected;
  ASSERT_TRUE(CreateOnCpu(scene, settings)->RenderReference(Moment(2), kSpp, &expected).ok());
  settings.seed = 17;
  ASSERT_TRUE(Create(scene, settings)->RenderReference(Moment(2), kSpp, &found).ok());
  double sum = 0;
  double squares = 0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double d = Luminance709(Pixel(found, x, y)) - Luminance709(Pixel(expected, x, y));
      sum += d;
      squares += d * d;
    }
  }
  const double n = size * size;
  const double error = std::sqrt((squares - sum * sum / n) / (n - 1) / n);
  EXPECT_LT(std::abs(sum / n), 3.5 * error);
  EXPECT_LT(error, 0.02 * Luminance709(Mean(expected)));  // the test is sensitive enough
}

TEST_P(GpuRendererTest, SameBitsEveryTime) {
  LeaveValidation();
  const Result<Scene> scene = MakeBuiltinScene("lights");
  RenderSettings settings = SmallSettings(kWidth, kHeight, 2);
  Frame frames[2];
  for (Frame& frame : frames) {
    const std::unique_ptr<Renderer> device = Create(*scene, settings);
    Frame before;
    ASSERT_TRUE(device->RenderFrame(Moment(1), &before).ok());
    ASSERT_TRUE(device->RenderFrame(Moment(2), &frame).ok());
  }
  for (size_t k = 0; k < frames[0].signals.size(); ++k) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(Pixel(frames[0].signals[k].radiance, x, y),
                  Pixel(frames[1].signals[k].radiance, x, y));
      }
    }
  }
}

// One renderer, again and again: what it keeps from frame to frame must not show.
TEST_P(GpuRendererTest, TheSameFrameAgainHasTheSameBits) {
  LeaveValidation();
  const std::pair<const char*, Scene> scenes[] = {{"everything", EverythingScene()},
                                                  {"deforming", DeformingScene(10)}};
  for (const auto& [name, scene] : scenes) {
    SCOPED_TRACE(name);
    const std::unique_ptr<Renderer> device = Create(scene, SmallSettings(kWidth, kHeight, 1));
    ASSERT_NE(device, nullptr);
    Frame first;
    ASSERT_TRUE(device->RenderFrame(Moment(3), &first).ok());
    for (int again = 1; again < 4; ++again) {
      Frame frame;
      ASSERT_TRUE(device->RenderFrame(Moment(3), &frame).ok());
      int differing = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          bool differs = false;
          for (size_t k = 0; k < first.signals.size(); ++k) {
            const vec3 a = Pixel(first.signals[k].radiance, x, y);
            const vec3 b = Pixel(frame.signals[k].radiance, x, y);
            differs = differs || a != b;
          }
          differing += differs ? 1 : 0;
        }
      }
      EXPECT_EQ(differing, 0) << "render " << again;
    }
  }
}

TEST_P(GpuRendererTest, SettingsMayChange) {
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  const std::unique_ptr<Renderer> device = Create(*scene, SmallSettings(9, 7, 1));
  Frame frame;
  ASSERT_TRUE(device->RenderFrame({}, &frame).ok());
  RenderSettings settings = SmallSettings(kWidth, kHeight, 2);
  settings.bounces = 2;
  ASSERT_TRUE(device->SetSettings(settings).ok());
  ASSERT_TRUE(device->RenderFrame(Moment(1), &frame).ok());
  EXPECT_EQ(frame.width, kWidth);
  Frame expected;
  ASSERT_TRUE(CreateOnCpu(*scene, settings)->RenderFrame(Moment(1), &expected).ok());
  ExpectFew(Differing(frame, expected), 2 * kPerThousand);
  // A smaller one, in the room of the one before.
  settings.width = kWidth - 10;
  settings.height = kHeight - 3;
  ASSERT_TRUE(device->SetSettings(settings).ok());
  ASSERT_TRUE(device->RenderFrame(Moment(2), &frame).ok());
  ASSERT_TRUE(CreateOnCpu(*scene, settings)->RenderFrame(Moment(2), &expected).ok());
  EXPECT_EQ(frame.width, kWidth - 10);
  ExpectFew(Differing(frame, expected), 2 * kPerThousand);
  settings.spp = 0;
  EXPECT_THAT(device->SetSettings(settings).message(), HasSubstr("spp is '0'"));
  EXPECT_EQ(device->settings().spp, 2);
}

TEST_P(GpuRendererTest, RenderersOfADeviceShareItsPipelines) {
  LeaveValidation();
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  const RenderSettings settings = SmallSettings(9, 7, 1);
  const auto created = [&] { return device_->context().pipelines->created(); };
  std::unique_ptr<Renderer> first = Create(*scene, settings);
  Frame expected;
  ASSERT_TRUE(first->RenderFrame(Moment(1), &expected).ok());
  const size_t of_one = created();
  EXPECT_GT(of_one, 0u);
  const std::unique_ptr<Renderer> second = Create(*scene, settings);
  Frame found;
  ASSERT_TRUE(second->RenderFrame(Moment(1), &found).ok());
  EXPECT_EQ(Differing(found, expected), 0);
  EXPECT_EQ(created(), of_one);
  first.reset();  // what it made stays
  ASSERT_TRUE(second->RenderFrame(Moment(2), &found).ok());
  ASSERT_TRUE(Create(*scene, settings)->RenderFrame(Moment(2), &expected).ok());
  EXPECT_EQ(Differing(found, expected), 0);
  EXPECT_EQ(created(), of_one);
}

TEST_P(GpuRendererTest, ProgressRisesAndCancels) {
  const Result<Scene> scene = MakeBuiltinScene("cornell");
  const std::unique_ptr<Renderer> device = Create(*scene, SmallSettings(200, 200, 1));
  Frame frame;
  std::vector<double> parts;
  ASSERT_TRUE(device
                  ->RenderFrame(Moment(1), &frame,
                                [&](double part) {
                                  parts.push_back(part);
                                  return true;
                                })
                  .ok());
  ASSERT_GT(parts.size(), 1u);
  EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end()));
  EXPECT_EQ(parts.back(), 1.0);
  const Status stopped = device->RenderFrame(Moment(2), &frame, [](double) { return false; });
  EXPECT_EQ(stopped.code(), StatusCode::kCancelled);
}

TEST_P(GpuRendererTest, EmptyAndBrokenScenes) {
  SceneBuilder builder;
  Frame frame;
  ASSERT_TRUE(Create(builder.scene, SmallSettings(5, 3, 2))->RenderFrame({}, &frame).ok());
  EXPECT_EQ(Mean(SumOfLight(frame)), vec3(0.0f));
  // Vertices and transforms that are not numbers are no surfaces; the rest is there.
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Mesh broken = Quad(vec3(-1, -1, -2), vec3(2, 0, 0), vec3(0, 2, 0));
  broken.positions[1].x = nan;
  builder.Add(broken, Emitter(vec3(1)));
  builder.Add(Quad(vec3(-1, -1, -3), vec3(2, 0, 0), vec3(0, 2, 0)), Emitter(vec3(1, 2, 3)));
  ExpectTheCpus(builder.scene, SmallSettings(16, 16, 1), 0, 0);
}

TEST_P(GpuRendererTest, SaysWhatIsWrong) {
  SceneBuilder builder;
  RenderSettings settings = SmallSettings(8, 8, 1);
  settings.bounces = 0;
  EXPECT_THAT(CreateVulkanRenderer(builder.scene, settings, device_).status().message(),
              HasSubstr("bounces is '0'"));
  const std::unique_ptr<Renderer> device = Create(builder.scene, SmallSettings(8, 8, 1));
  EXPECT_THAT(device->RenderFrame({}, nullptr).message(), HasSubstr("frame is null"));
  Image3 image;
  EXPECT_THAT(device->RenderReference({}, 0, &image).message(), HasSubstr("spp of the reference"));
  Frame frame;
  RenderMoment moment;
  moment.camera = 4;
  EXPECT_EQ(device->RenderFrame(moment, &frame).code(), StatusCode::kInvalidArgument);
}

STILLRAY_IN_BOTH_WAYS(GpuRendererTest);

}  // namespace
}  // namespace stillray::render
