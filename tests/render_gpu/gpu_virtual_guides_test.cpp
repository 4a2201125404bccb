// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Virtual guides that the device finds are those of the tracer on the CPU.
#include <tuple>

#include <gmock/gmock.h>

#include "render/deforming_scene.h"
#include "render/test_scenes.h"
#include "render/vulkan/vulkan_renderer.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/tracing_ways.h"
#include "scene/builtin.h"

namespace stillray::render {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 64;
constexpr int kPixels = kWidth * kHeight;

// Of values near 1, and relative to larger ones. Curved glass multiplies the rounding of hits and
// normals at each of its surfaces.
constexpr double kTolerance = 2e-3;
// Pixels; Newton's method ends at steps of 0.002.
constexpr double kMotionTolerance = 0.02;
// Pixels whose chain passes an edge, or meets a surface by the other of two decisions: so many in
// 10000.
constexpr int kPerTenThousand = 30;

double Off(double a, double b) {
  if (a == b) {
    return 0;  // infinities too
  }
  return std::isfinite(a) && std::isfinite(b) ? std::abs(a - b) / std::max(1.0, std::abs(b)) : 1e30;
}

double Off(vec3 a, vec3 b) {
  return std::max({Off(a.x, b.x), Off(a.y, b.y), Off(a.z, b.z)});
}

RenderMoment MomentAt(double seconds, double previous_seconds) {
  RenderMoment moment;
  moment.frame_index = 3;
  moment.seconds = seconds;
  moment.previous_seconds = previous_seconds;
  return moment;
}

class GpuRendererTestVirtualGuides : public TracingWaysTest {
 protected:
  std::unique_ptr<Renderer> Create(const Scene& scene, const RenderSettings& settings) {
    auto renderer = CreateVulkanRenderer(scene, settings, device_, {.way = GetParam()});
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    return renderer.ok() ? std::move(*renderer) : nullptr;
  }

  Frame RenderOnDevice(const Scene& scene, const RenderSettings& settings,
                       const RenderMoment& moment) {
    const std::unique_ptr<Renderer> renderer = Create(scene, settings);
    Frame frame;
    if (renderer != nullptr) {
      const Status status = renderer->RenderFrame(moment, &frame);
      EXPECT_TRUE(status.ok()) << status.message();
    }
    return frame;
  }

  static void ExpectSame(const VirtualGuides& found, const VirtualGuides& expected,
                         int least_images) {
    ASSERT_FALSE(found.empty());
    ASSERT_FALSE(expected.empty());
    ASSERT_EQ(found.depth.width(), expected.depth.width());
    struct Count {
      const char* what;
      int wrong = 0;
    };
    Count depth{"image depth"}, normal{"image normal"}, albedo{"image albedo"},
        motion{"image motion"}, id{"image id"};
    int shown = 0;
    for (int y = 0; y < expected.depth.height(); ++y) {
      for (int x = 0; x < expected.depth.width(); ++x) {
        const float e = expected.depth(x, y);
        const double moved = std::max(std::abs(found.motion[0](x, y) - expected.motion[0](x, y)),
                                      std::abs(found.motion[1](x, y) - expected.motion[1](x, y)));
        shown += e != 0 ? 1 : 0;
        depth.wrong += Off(found.depth(x, y), e) <= kTolerance ? 0 : 1;
        normal.wrong +=
            Off(Pixel(found.normal, x, y), Pixel(expected.normal, x, y)) <= kTolerance ? 0 : 1;
        albedo.wrong +=
            Off(Pixel(found.albedo, x, y), Pixel(expected.albedo, x, y)) <= kTolerance ? 0 : 1;
        motion.wrong += moved <= kMotionTolerance ? 0 : 1;
        id.wrong += found.id(x, y) != expected.id(x, y) ? 1 : 0;
      }
    }
    EXPECT_GE(shown, least_images);
    for (const Count& count : {depth, normal, albedo, motion, id}) {
      test::RecordLargest(count.what, count.wrong, kPixels * kPerTenThousand / 10000);
      EXPECT_LE(count.wrong, kPixels * kPerTenThousand / 10000) << count.what;
    }
  }

  // \return the number of pixels with an image
  static int ExpectEqualImages(const VirtualGuides& found, const VirtualGuides& expected) {
    EXPECT_EQ(found.depth.width(), expected.depth.width());
    int shown = 0;
    int wrong = 0;
    for (int y = 0; y < expected.depth.height(); ++y) {
      for (int x = 0; x < expected.depth.width(); ++x) {
        shown += expected.depth(x, y) != 0 ? 1 : 0;
        const bool same = found.depth(x, y) == expected.depth(x, y) &&
                          Pixel(found.normal, x, y) == Pixel(expected.normal, x, y) &&
                          Pixel(found.albedo, x, y) == Pixel(expected.albedo, x, y) &&
                          found.motion[0](x, y) == expected.motion[0](x, y) &&
                          found.motion[1](x, y) == expected.motion[1](x, y) &&
                          found.id(x, y) == expected.id(x, y);
        wrong += same ? 0 : 1;
      }
    }
    EXPECT_EQ(wrong, 0);
    return shown;
  }

  static void ExpectSameAlbedo(const Image3& found, const Image3& expected) {
    int wrong = 0;
    for (int y = 0; y < expected.height(); ++y) {
      for (int x = 0; x < expected.width(); ++x) {
        wrong += Off(Pixel(found, x, y), Pixel(expected, x, y)) <= kTolerance ? 0 : 1;
      }
    }
    EXPECT_LE(wrong, kPixels * kPerTenThousand / 10000);
  }

  // The frame at a moment when things move.
  void ExpectTheCpus(const Scene& scene, RenderSettings settings, int least_images,
                     int least_transmitted = 0, double seconds = 0.7,
                     double previous_seconds = 0.5) {
    const RenderMoment moment = MomentAt(seconds, previous_seconds);
    const std::unique_ptr<Renderer> renderer = Create(scene, settings);
    ASSERT_NE(renderer, nullptr);
    Frame found;
    const Status status = renderer->RenderFrame(moment, &found);
    ASSERT_TRUE(status.ok()) << status.message();
    const auto cpu = Renderer::Create(scene, settings);
    ASSERT_TRUE(cpu.ok());
    Frame expected;
    ASSERT_TRUE((*cpu)->RenderFrame(moment, &expected).ok());
    ASSERT_EQ(found.signals.size(), expected.signals.size());
    ASSERT_EQ(found.refraction.empty(), expected.refraction.empty());
    if (!expected.refraction.empty()) {
      SCOPED_TRACE("refraction");
      ExpectSame(found.refraction, expected.refraction, least_transmitted);
      ExpectSameAlbedo(found.guides.transmission_albedo, expected.guides.transmission_albedo);
      ExpectSameAlbedo(found.guides.specular_albedo, expected.guides.specular_albedo);
      ExpectSameAlbedo(found.guides.albedo, expected.guides.albedo);
    }
    ASSERT_EQ(found.reflection.empty(), expected.reflection.empty());
    if (!expected.reflection.empty()) {
      ExpectSame(found.reflection, expected.reflection, least_images);
    }
    const auto rays = static_cast<double>((*cpu)->timings().image_rays);
    EXPECT_NEAR(static_cast<double>(renderer->timings().image_rays), rays, 0.01 * rays + 1);
  }
};

TEST_P(GpuRendererTestVirtualGuides, OfBuiltinScenesAreTheCpus) {
  for (const auto& [name, least, transmitted] :
       {std::tuple{"mirrors", 900, 300}, {"spheres", 300, 80}}) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
    settings.jitter = true;
    ExpectTheCpus(*scene, settings, least, transmitted);
  }
}

// A mirror that turns and is scaled, opposite a wall that moves, before a camera that moves.
TEST_P(GpuRendererTestVirtualGuides, OfAMovingMirrorAreTheCpus) {
  SceneBuilder builder;
  const int mirror = builder.Add(Quad(vec3(-6, -6, 0), vec3(12, 0, 0), vec3(0, 12, 0)),
                                 Metal(vec3(0.8f, 0.9f, 1.0f), 0.0f), At(vec3(0, 0, -4)));
  AnimationChannel rotation;
  rotation.node = builder.InstanceNode(mirror);
  rotation.property = AnimatedProperty::kRotation;
  rotation.times = {0.0f, 1.0f};
  rotation.values = {Rotation(vec3(0, 1, 0), 0.0f), Rotation(vec3(0, 1, 0), 0.05f)};
  builder.scene.animation.push_back(rotation);
  const int wall = builder.Add(Quad(vec3(40, -40, 0), vec3(-80, 0, 0), vec3(0, 80, 0)),
                               Lambert(vec3(0.5f, 0.25f, 0.75f)), At(vec3(0, 0, 3)));
  builder.Move(builder.InstanceNode(wall), vec3(0.3f, -0.2f, 0.0f));
  builder.Move(0, vec3(0.1f, 0.05f, -0.2f));
  ExpectTheCpus(builder.scene, SmallSettings(kWidth, kHeight, 1), kPixels);
}

// A chrome tube that bends: its surface one frame ago is that of the previous pose.
TEST_P(GpuRendererTestVirtualGuides, OfAMirrorThatDeformsAreTheCpus) {
  Scene scene = DeformingScene(20);
  const int tube = scene.meshes[static_cast<size_t>(scene.instances[1].mesh)].material;
  scene.materials[static_cast<size_t>(tube)] = Metal(vec3(0.9f, 0.6f, 0.3f), 0.0f);
  ExpectTheCpus(scene, SmallSettings(kWidth, kHeight, 1), 100);
}

// Balls of glass and of chrome in a room, a pane with a lamp that it reflects, and mirrors behind
// it that face each other.
TEST_P(GpuRendererTestVirtualGuides, OfGlassAndChromeAreTheCpus) {
  SceneBuilder builder;
  const int glass =
      builder.Add(MakeSphere(1, 96, 64, 0), Glass(1.5f, 0.0f), At(vec3(-1.2f, 0, -4)));
  builder.Add(MakeSphere(1, 96, 64, 0), Metal(vec3(0.9f, 0.8f, 0.7f), 0.05f),
              At(vec3(1.2f, 0, -4)));
  builder.Add(Box(vec3(-5), vec3(5), true), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(0.5f, 2.0f, 1), vec3(-1, 0, 0), vec3(0, 1, 0)), Emitter(vec3(20.0f)));
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  builder.Add(Quad(vec3(-3, -3, -2), vec3(6, 0, 0), vec3(0, 2, 0)), sheet);
  builder.Move(0, vec3(0.08f, 0.03f, 0.05f));
  builder.Move(builder.InstanceNode(glass), vec3(0.05f, 0.1f, 0.0f));
  ExpectTheCpus(builder.scene, SmallSettings(kWidth, kHeight, 1), kPixels / 4, 1000);
}

// Blended layers before and behind each other, some of which move, and one alone.
TEST_P(GpuRendererTestVirtualGuides, OfBlendedLayersAreTheCpus) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(2.0f, 3.0f, 4.0f);
  float z = -3;
  for (const float alpha : {0.3f, 0.6f, 0.5f}) {
    Material blended = Lambert(vec3(0.7f, alpha, 0.2f));
    blended.alpha_mode = AlphaMode::kBlend;
    blended.base_color.w = alpha;
    const int sheet =
        builder.Add(Quad(vec3(-1, -6, 0), vec3(12, 0, 0), vec3(0, 12, 0)), blended, At({0, 0, z}));
    builder.Move(builder.InstanceNode(sheet), vec3(alpha, 0.1f, 0.0f));
    z -= 1;
  }
  builder.Add(Quad(vec3(1, -9, -7), vec3(18, 0, 0), vec3(0, 18, 0)), Lambert(vec3(0.5f)));
  builder.Move(0, vec3(0.1f, 0.0f, 0.05f));
  ExpectTheCpus(builder.scene, SmallSettings(kWidth, kHeight, 1), 0, kPixels / 4);
}

TEST_P(GpuRendererTestVirtualGuides, OfEverythingAreTheCpus) {
  Scene scene = EverythingScene();
  scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  ExpectTheCpus(scene, SmallSettings(kWidth, kHeight, 1), 50);
}

// One half-transparent mirror before the sky: a single surface, of part of the pixel.
TEST_P(GpuRendererTestVirtualGuides, OfALayerBeforeTheSkyAreTheCpus) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(2.0f, 3.0f, 4.0f);
  Material blended = Metal(vec3(0.5f), 0.0f);
  blended.alpha_mode = AlphaMode::kBlend;
  blended.base_color.w = 0.6f;
  builder.Add(Quad(vec3(-1, -6, -4), vec3(12, 0, 0), vec3(0, 12, 0)), blended);
  builder.Add(Quad(vec3(6, -6, -5), vec3(-3, 0, 0), vec3(0, 12, 0)), Lambert(vec3(0.5f)));
  builder.Move(0, vec3(0.3f, 0.0f, 0.0f));
  ExpectTheCpus(builder.scene, SmallSettings(kWidth, kHeight, 1), kPixels / 8);
}

// Several samples share them; sparse frames have them in all pixels, if they have guides there.
TEST_P(GpuRendererTestVirtualGuides, OfOtherSampleCountsAreTheCpus) {
  const Result<Scene> scene = MakeBuiltinScene("mirrors");
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.spp = 2;
  ExpectTheCpus(*scene, settings, 900);
  settings.spp = 1;
  settings.cycle = 4;
  ExpectTheCpus(*scene, settings, 900);
}

TEST_P(GpuRendererTestVirtualGuides, AreOnlyWhereTheCpuHasThem) {
  const Result<Scene> mirrors = MakeBuiltinScene("mirrors");
  const Result<Scene> cornell = MakeBuiltinScene("cornell");
  const RenderMoment moment = MomentAt(0.1, 0.0);
  RenderSettings settings = SmallSettings(24, 16, 1);
  const std::unique_ptr<Renderer> renderer = Create(*mirrors, settings);
  ASSERT_NE(renderer, nullptr);
  Frame frame;
  ASSERT_TRUE(renderer->RenderFrame(moment, &frame).ok());
  EXPECT_FALSE(frame.reflection.empty());
  EXPECT_GT(renderer->timings().image_rays, 0u);
  const Frame with = frame;
  // Off: the frame keeps none of those that it had, and the light of surfaces is the same.
  settings.virtual_guides = false;
  ASSERT_TRUE(renderer->SetSettings(settings).ok());
  ASSERT_TRUE(renderer->RenderFrame(moment, &frame).ok());
  EXPECT_TRUE(frame.reflection.empty());
  EXPECT_EQ(renderer->timings().image_rays, 0u);
  ASSERT_EQ(with.signals.size(), 6u);
  ASSERT_EQ(frame.signals.size(), 4u);
  EXPECT_TRUE(frame.guides.transmission_albedo.empty());
  for (size_t k = 0; k < frame.signals.size(); ++k) {
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 24; ++x) {
        if (Pixel(with.guides.transmission_albedo, x, y) == vec3(0.0f)) {
          ASSERT_EQ(Pixel(with.signals[k].radiance, x, y), Pixel(frame.signals[k].radiance, x, y));
        }
      }
    }
  }
  settings.virtual_guides = true;
  settings.aperture = 0.05f;
  ASSERT_TRUE(renderer->SetSettings(settings).ok());
  ASSERT_TRUE(renderer->RenderFrame(moment, &frame).ok());
  EXPECT_TRUE(frame.reflection.empty());
  settings.aperture = std::nullopt;
  settings.cycle = 4;
  settings.guides = GuideCoverage::kSparse;
  ASSERT_TRUE(renderer->SetSettings(settings).ok());
  ASSERT_TRUE(renderer->RenderFrame(moment, &frame).ok());
  EXPECT_TRUE(frame.reflection.empty());
  // A renderer without memory for them makes room when they are switched on.
  settings.guides = GuideCoverage::kFull;
  settings.virtual_guides = false;
  const std::unique_ptr<Renderer> without = Create(*mirrors, settings);
  settings.virtual_guides = true;
  ASSERT_TRUE(without->SetSettings(settings).ok());
  ASSERT_TRUE(without->RenderFrame(moment, &frame).ok());
  EXPECT_FALSE(frame.reflection.empty());
  const Frame matte = RenderOnDevice(*cornell, SmallSettings(24, 16, 1), moment);
  EXPECT_EQ(matte.reflection.empty(),
            RenderOne(*cornell, SmallSettings(24, 16, 1), moment).reflection.empty());
}

// Whether frames stay on the device or come to the host, for all combinations of samples.
TEST_P(GpuRendererTestVirtualGuides, OfFramesOnTheDeviceAreThoseOnTheHost) {
  const Result<Scene> scene = MakeBuiltinScene("mirrors");
  RenderSettings settings = SmallSettings(45, 27, 1);
  const std::unique_ptr<Renderer> renderer = Create(*scene, settings);
  ASSERT_NE(renderer, nullptr);
  for (const auto& [spp, cycle] : {std::pair{1, 1}, {2, 1}, {1, 4}}) {
    settings.spp = spp;
    settings.cycle = cycle;
    Frame frames[2];
    for (const bool on_device : {false, true}) {
      Frame& frame = frames[on_device ? 1 : 0];
      settings.on_device = on_device;
      ASSERT_TRUE(renderer->SetSettings(settings).ok());
      ASSERT_TRUE(renderer->RenderFrame(MomentAt(0.1, 0.0), &frame).ok());
      ASSERT_EQ(frame.on_device != nullptr, on_device);
      EXPECT_GT(renderer->timings().image_rays, 0u);
    }
    ASSERT_TRUE(frames[1].on_device->has_reflection());
    ASSERT_TRUE(frames[1].on_device->has_refraction());
    EXPECT_TRUE(frames[1].reflection.empty());
    Frame host;
    ASSERT_TRUE(OnHost(frames[1], &host).ok());
    EXPECT_GT(ExpectEqualImages(host.reflection, frames[0].reflection), 150);
    EXPECT_GT(ExpectEqualImages(host.refraction, frames[0].refraction), 50);
    ASSERT_EQ(host.signals.size(), 6u);
    ASSERT_EQ(frames[0].signals.size(), 6u);
    for (int y = 0; y < 27; ++y) {
      for (int x = 0; x < 45; ++x) {
        ASSERT_EQ(Pixel(host.guides.transmission_albedo, x, y),
                  Pixel(frames[0].guides.transmission_albedo, x, y));
        for (size_t k = 0; k < 6; ++k) {
          ASSERT_EQ(Pixel(host.signals[k].radiance, x, y),
                    Pixel(frames[0].signals[k].radiance, x, y));
          if (spp > 1) {
            ASSERT_EQ(host.signals[k].second_moment(x, y),
                      frames[0].signals[k].second_moment(x, y));
          }
        }
      }
    }
  }
}

// Off, seen through a lens, or with sparse guides: no images, and no memory for them.
TEST_P(GpuRendererTestVirtualGuides, FramesOnTheDeviceHaveThemOnlyWhereTheHostDoes) {
  const Result<Scene> scene = MakeBuiltinScene("mirrors");
  RenderSettings settings = SmallSettings(24, 16, 1);
  settings.on_device = true;
  const std::unique_ptr<Renderer> renderer = Create(*scene, settings);
  ASSERT_NE(renderer, nullptr);
  Frame frame;
  Frame host;
  const auto render = [&] {
    EXPECT_TRUE(renderer->SetSettings(settings).ok());
    EXPECT_TRUE(renderer->RenderFrame(MomentAt(0.1, 0.0), &frame).ok());
    return frame.on_device->has_reflection();
  };
  EXPECT_TRUE(render());
  const uint64_t with = frame.on_device->bytes();
  ASSERT_TRUE(OnHost(frame, &host).ok());
  EXPECT_FALSE(host.reflection.empty());
  settings.virtual_guides = false;
  EXPECT_FALSE(render());
  EXPECT_EQ(renderer->timings().image_rays, 0u);
  EXPECT_GE(with - frame.on_device->bytes(), 24u * 16 * 48);
  // The host's planes of an earlier frame do not stay.
  ASSERT_TRUE(OnHost(frame, &host).ok());
  EXPECT_TRUE(host.reflection.empty());
  settings.virtual_guides = true;
  settings.aperture = 0.05f;
  EXPECT_FALSE(render());
  settings.aperture = std::nullopt;
  settings.cycle = 4;
  settings.guides = GuideCoverage::kSparse;
  EXPECT_FALSE(render());
  settings.guides = GuideCoverage::kFull;
  EXPECT_TRUE(render());
}

STILLRAY_IN_BOTH_WAYS(GpuRendererTestVirtualGuides);

}  // namespace
}  // namespace stillray::render
