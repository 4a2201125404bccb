// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Textures averaged over the pixel: guides and paths on the device have the base colours of the
// tracer on the CPU, and paths have those of their guides.
#include <gmock/gmock.h>

#include "core/random.h"
#include "render/test_scenes.h"
#include "render/vulkan/trace_shared.h"
#include "render/vulkan/vulkan_renderer.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/expect_frame.h"
#include "render_gpu/moments.h"
#include "render_gpu/tracing_ways.h"
#include "scene/builtin.h"

namespace stillray::render {
namespace {

constexpr int kWidth = 96;
constexpr int kHeight = 64;
constexpr int kPixels = kWidth * kHeight;
// Of values near 1, and relative to larger ones, as in gpu_virtual_guides_test.cpp.
constexpr float kTolerance = 2e-3f;
// Pixels whose ray, chain or path takes another way by a rounding, in a thousand.
constexpr int kPerThousand = 8;

RenderSettings Settings() {
  RenderSettings settings = SmallSettings(kWidth, kHeight, 1);
  settings.jitter = true;
  return settings;
}

// A panel whose texture repeats, with about ten texels along each axis of a pixel.
Mesh FinePanel(vec3 o, vec3 x, vec3 y, float repeats) {
  Mesh panel = Quad(o, x, y);
  for (vec2& uv : panel.uv[0]) {
    uv *= repeats;
  }
  return panel;
}

Material Textured(vec3 colour, int texture) {
  Material material = Lambert(colour);
  material.base_color_texture.texture = texture;
  return material;
}

// A wall behind things: a mirror that turns, chrome and glass balls, a thin pane, and a wall behind
// the camera; light from everywhere. Colours of vertices and a texture transform on the wall.
Scene FineTextures() {
  SceneBuilder builder;
  builder.scene.textures = EverythingTextures();
  builder.scene.environment.radiance = vec3(0.9f, 1.0f, 1.1f);
  Material wall = Textured(vec3(0.9f, 0.8f, 0.7f), 0);
  wall.base_color_texture.transform[0] = vec3(0.8f, 0.6f, 0.0f);
  wall.base_color_texture.transform[1] = vec3(-0.6f, 0.8f, 0.0f);
  Mesh back = FinePanel(vec3(-8, -6, -7), vec3(16, 0, 0), vec3(0, 12, 0), 14.0f);
  back.colors = {vec4(1.0f), vec4(0.3f, 1, 1, 1), vec4(1, 0.3f, 1, 1), vec4(1, 1, 0.3f, 1)};
  builder.Add(back, wall);
  builder.Add(FinePanel(vec3(9, -9, 5), vec3(-18, 0, 0), vec3(0, 18, 0), 30.0f),
              Textured(vec3(0.9f), 2));
  const int mirror = builder.Add(Quad(vec3(-1.2f, -1, 0), vec3(2.4f, 0, 0), vec3(0, 2, 0)),
                                 Metal(vec3(0.9f), 0.0f), At(vec3(-2.2f, 0.8f, -5)));
  builder.Turn(builder.InstanceNode(mirror), vec3(0, 1, 0), {0.0f, 0.1f, 0.25f, 0.4f, 0.5f});
  builder.Add(MakeSphere(0.8f, 96, 64, 0), Metal(vec3(0.9f, 0.8f, 0.7f), 0.0f),
              At(vec3(0.4f, 1.0f, -5)));
  builder.Add(MakeSphere(0.8f, 96, 64, 0), Glass(1.5f, 0.0f), At(vec3(-0.6f, -1.1f, -5)));
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  builder.Add(Quad(vec3(1.2f, -2, -5), vec3(2, 0, 0), vec3(0, 3.6f, 0)), sheet);
  Material cut = Textured(vec3(0.9f, 0.4f, 0.3f), 1);
  cut.alpha_mode = AlphaMode::kMask;
  builder.Add(FinePanel(vec3(-3.4f, -2, -5), vec3(1.8f, 0, 0), vec3(0, 1.4f, 0), 4.0f), cut);
  builder.Move(0, vec3(0.1f, 0.05f, -0.2f));
  return builder.scene;
}

bool IsNear(vec3 found, vec3 expected, float tolerance) {
  return MaxComponent(abs(found - expected)) <=
         tolerance * std::max(1.0f, MaxComponent(abs(expected)));
}

int CountDiffering(const Image3& found, const Image3& expected, float tolerance) {
  EXPECT_EQ(found.width(), expected.width());
  EXPECT_EQ(found.height(), expected.height());
  int differing = 0;
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      differing += IsNear(Pixel(found, x, y), Pixel(expected, x, y), tolerance) ? 0 : 1;
    }
  }
  return differing;
}

// Walls before and behind the camera with a texture (-1: none); on the left a mirror, on the right
// a pane of glass.
Scene Walls(int texture) {
  SceneBuilder builder;
  builder.scene.textures = EverythingTextures();
  builder.scene.environment.radiance = vec3(1.0f);
  const Material wall = Textured(vec3(0.8f), texture);
  builder.Add(FinePanel(vec3(-9, -9, -7), vec3(18, 0, 0), vec3(0, 18, 0), 16.0f), wall);
  builder.Add(FinePanel(vec3(9, -9, 5), vec3(-18, 0, 0), vec3(0, 18, 0), 30.0f), wall);
  builder.Add(Quad(vec3(-4, -4, -4), vec3(3, 0, 0), vec3(0, 8, 0)), Metal(vec3(0.9f), 0.0f));
  Material sheet = Glass(1.5f, 0.0f);
  sheet.solid = false;
  builder.Add(Quad(vec3(1, -4, -4), vec3(3, 0, 0), vec3(0, 8, 0)), sheet);
  return builder.scene;
}

enum class Seen { kDirectly, kInMirror, kThroughGlass };

// The light of the wall that a pixel shows, divided by the wall's albedo in the guides; 0 without.
vec3 Demodulated(const Frame& frame, Seen seen, int x, int y) {
  const auto light = [&](SignalKind kind) {
    return Pixel(frame.signals[static_cast<size_t>(kind)].radiance, x, y);
  };
  vec3 sum = light(SignalKind::kDirectDiffuse);
  vec3 albedo = Pixel(frame.guides.albedo, x, y);
  if (seen == Seen::kInMirror) {
    sum = light(SignalKind::kDirectSpecular) + light(SignalKind::kIndirectSpecular);
    albedo = Pixel(frame.reflection.albedo, x, y);
  } else if (seen == Seen::kThroughGlass) {
    sum = light(SignalKind::kDirectTransmission) + light(SignalKind::kIndirectTransmission);
    albedo = Pixel(frame.refraction.albedo, x, y);
  }
  return std::min({albedo.x, albedo.y, albedo.z}) > 0.01f ? sum / albedo : vec3(0.0f);
}

class GpuBaseColourTest : public TracingWaysTest {
 protected:
  std::unique_ptr<Renderer> Create(const Scene& scene, const RenderSettings& settings) {
    auto renderer = CreateVulkanRenderer(scene, settings, device_, {.way = GetParam()});
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    return renderer.ok() ? std::move(*renderer) : nullptr;
  }

  Frame RenderOnDevice(const Scene& scene, const RenderSettings& settings) {
    const std::unique_ptr<Renderer> renderer = Create(scene, settings);
    Frame frame;
    EXPECT_TRUE(renderer != nullptr && renderer->RenderFrame(Moment(3), &frame).ok());
    return frame;
  }

  static Frame RenderOnCpu(const Scene& scene, const RenderSettings& settings) {
    auto renderer = Renderer::Create(scene, settings);
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    Frame frame;
    EXPECT_TRUE(renderer.ok() && (*renderer)->RenderFrame(Moment(3), &frame).ok());
    return frame;
  }

  static void ExpectNear(const Image3& found, const Image3& expected, const char* what) {
    const int differing = CountDiffering(found, expected, kTolerance);
    test::RecordLargest(what, differing, kPixels * kPerThousand / 1000);
    EXPECT_LE(differing, kPixels * kPerThousand / 1000) << what;
  }

  // Albedos and light.
  static void ExpectNear(const Frame& found, const Frame& expected) {
    ExpectNear(found.guides.albedo, expected.guides.albedo, "albedo");
    ExpectNear(found.guides.specular_albedo, expected.guides.specular_albedo, "specular albedo");
    ASSERT_EQ(found.reflection.empty(), expected.reflection.empty());
    ExpectNear(found.reflection.albedo, expected.reflection.albedo, "albedo of reflections");
    ASSERT_EQ(found.refraction.empty(), expected.refraction.empty());
    ExpectNear(found.refraction.albedo, expected.refraction.albedo, "albedo of refractions");
    ASSERT_EQ(found.signals.size(), expected.signals.size());
    for (size_t k = 0; k < expected.signals.size(); ++k) {
      ExpectNear(found.signals[k].radiance, expected.signals[k].radiance,
                 SignalName(expected.signals[k].kind));
    }
  }

  void ExpectTheCpus(const Scene& scene, const RenderSettings& settings) {
    ExpectNear(RenderOnDevice(scene, settings), RenderOnCpu(scene, settings));
  }
};

TEST_P(GpuBaseColourTest, OfFineTexturesAreTheCpus) {
  LeaveValidation();
  const Scene scene = FineTextures();
  RenderSettings settings = Settings();
  const Frame mean = RenderOnDevice(scene, settings);
  ExpectNear(mean, RenderOnCpu(scene, settings));
  settings.filter_textures = false;
  const Frame points = RenderOnDevice(scene, settings);
  ExpectNear(points, RenderOnCpu(scene, settings));
  // The mean is another colour, directly, in mirrors and through glass.
  EXPECT_GT(CountDiffering(mean.guides.albedo, points.guides.albedo, 0.05f), kPixels / 3);
  EXPECT_GT(CountDiffering(mean.reflection.albedo, points.reflection.albedo, 0.05f), kPixels / 12);
  EXPECT_GT(CountDiffering(mean.refraction.albedo, points.refraction.albedo, 0.05f), kPixels / 12);
  // Without jitter nothing is averaged.
  settings.jitter = false;
  const Frame centres = RenderOnDevice(scene, settings);
  settings.filter_textures = true;
  const Frame same = RenderOnDevice(scene, settings);
  ExpectFrame(same, centres);
}

TEST_P(GpuBaseColourTest, OfOtherSampleCountsAreTheCpus) {
  LeaveValidation();
  RenderSettings settings = Settings();
  settings.spp = 2;
  ExpectTheCpus(FineTextures(), settings);
  settings.spp = 1;
  settings.cycle = 4;
  ExpectTheCpus(FineTextures(), settings);
  settings.guides = GuideCoverage::kSparse;
  ExpectTheCpus(FineTextures(), settings);
}

TEST_P(GpuBaseColourTest, WithoutVirtualGuidesAndThroughALensAreTheCpus) {
  LeaveValidation();
  RenderSettings settings = Settings();
  settings.virtual_guides = false;
  ExpectTheCpus(FineTextures(), settings);
  settings.aperture = 0.02f;
  settings.spp = 2;
  ExpectTheCpus(FineTextures(), settings);
}

// Before walls with and without a texture, under light from everywhere, the quotient of the light
// and the albedo by which it is demodulated is the same. So it is smooth.
TEST_P(GpuBaseColourTest, PathsHaveTheColoursOfTheirGuides) {
  LeaveValidation();
  RenderSettings settings = Settings();
  settings.bounces = 1;
  for (const int cycle : {1, 4}) {
    SCOPED_TRACE(cycle);
    settings.cycle = cycle;
    const Frame plain = RenderOnDevice(Walls(-1), settings);
    const Frame textured = RenderOnDevice(Walls(0), settings);
    for (const Seen seen : {Seen::kDirectly, Seen::kInMirror, Seen::kThroughGlass}) {
      SCOPED_TRACE(static_cast<int>(seen));
      int compared = 0;
      int differing = 0;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const vec3 expected = Demodulated(plain, seen, x, y);
          const vec3 found = Demodulated(textured, seen, x, y);
          if (MaxComponent(expected) > 0.0f && MaxComponent(found) > 0.0f) {
            ++compared;
            differing += IsNear(found, expected, 1e-3f) ? 0 : 1;
          }
        }
      }
      EXPECT_GT(compared, kPixels / cycle / 10);
      EXPECT_LE(differing, compared / 50);  // at edges of panels and triangles
    }
  }
}

TEST_P(GpuBaseColourTest, NothingStaysWhenSwitchedOff) {
  LeaveValidation();
  const Result<Scene> scene = MakeBuiltinScene("mirrors");
  RenderSettings settings = SmallSettings(40, 30, 1);
  settings.jitter = true;
  const std::unique_ptr<Renderer> switched = Create(*scene, settings);
  ASSERT_NE(switched, nullptr);
  Frame found;
  Image3 reference;
  ASSERT_TRUE(switched->RenderFrame(Moment(3), &found).ok());
  ASSERT_TRUE(switched->RenderReference(Moment(3), 2, &reference).ok());
  settings.filter_textures = false;
  ASSERT_TRUE(switched->SetSettings(settings).ok());
  const Frame averaged = std::exchange(found, {});
  ASSERT_TRUE(switched->RenderFrame(Moment(3), &found).ok());
  EXPECT_GT(CountDiffering(found.guides.albedo, averaged.guides.albedo, 0.01f), 40 * 30 / 10);
  ExpectFrame(found, RenderOnDevice(*scene, settings));
  Image3 expected;
  ASSERT_TRUE(Create(*scene, settings)->RenderReference(Moment(3), 2, &expected).ok());
  ExpectPlanes(reference, expected);
}

STILLRAY_IN_BOTH_WAYS(GpuBaseColourTest);

TEST(PackedColourTest, IsTheColourToHalfAStep) {
  for (uint32_t i = 0; i < 1000; ++i) {
    vec3 colour(UniformFloat(HashCombine(i, 1)), UniformFloat(HashCombine(i, 2)),
                UniformFloat(HashCombine(i, 3)));
    if (i < 27) {  // all combinations of none, the smallest step and all
      const float ends[] = {0.0f, 1.0f / 2097151.0f, 1.0f};
      colour = vec3(ends[i % 3], ends[i / 3 % 3], ends[i / 9]);
    }
    GpuGuides guides = {};
    SetColour(guides, colour);
    EXPECT_NE(guides.colour_high, 0u);
    const vec3 found = UnpackColour(guides.colour_low, guides.colour_high);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(found[k], colour[k], 0.5 / 2097151 + 6e-8) << i << " channel " << k;
    }
  }
  GpuGuides guides = {};
  SetColour(guides, vec3(1.0000001f, 0.0f, 1.0000001f));  // a mean may be rounded up
  EXPECT_EQ(UnpackColour(guides.colour_low, guides.colour_high), vec3(1.0f, 0.0f, 1.0f));
}

}  // namespace
}  // namespace stillray::render
