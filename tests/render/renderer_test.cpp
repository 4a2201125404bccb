// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/render.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <tbb/global_control.h>

#include "other_value.h"
#include "test_scenes.h"

namespace stillray::render::renderer_test {
namespace {

using ::testing::HasSubstr;

// Something of everything: metal, glass, a veil, lamps, a moving object.
SceneBuilder VariedScene() {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 0.5f, 3));
  Texture tiles;
  tiles.width = tiles.height = 64;
  for (int i = 0; i < 64 * 64; ++i) {
    const auto grey = static_cast<uint8_t>((i + i / 64) % 2 == 0 ? 255 : 240);
    tiles.texels.insert(tiles.texels.end(), {grey, grey, grey, 255});
  }
  builder.scene.textures = {tiles};
  Material floor = Lambert(vec3(0.7f, 0.6f, 0.5f));
  floor.base_color_texture.texture = 0;
  builder.Add(Quad(vec3(-4, -1, 4), vec3(8, 0, 0), vec3(0, 0, -8)), floor);
  Material plastic = Metal(vec3(0.2f, 0.4f, 0.8f), 0.3f);
  plastic.metallic = 0.0f;
  builder.Add(FacetedSphere(vec3(-1.2f, 0, -1), 0.8f, 2), plastic);
  builder.Add(FacetedSphere(vec3(0), 0.7f, 2), Glass(1.5f, 0.0f), At(vec3(0.6f, -0.2f, 0)));
  const int moving = builder.Add(FacetedSphere(vec3(0), 0.4f, 2),
                                 Metal(vec3(0.9f, 0.7f, 0.4f), 0.2f), At(vec3(1.5f, 0.4f, -1)));
  builder.Move(builder.InstanceNode(moving), vec3(-1, 0, 0));
  Material veil = Lambert(vec3(0.9f));
  veil.alpha_mode = AlphaMode::kBlend;
  veil.base_color.w = 0.5f;
  builder.Add(Quad(vec3(-2, -1, -2.5f), vec3(1.5f, 0, 0), vec3(0, 2, 0)), veil);
  builder.Add(Quad(vec3(-1, 2.5f, -1), vec3(2, 0, 0), vec3(0, 0, 2)), Emitter(vec3(4.0f)));
  builder.scene.environment.radiance = vec3(0.1f, 0.15f, 0.2f);
  return builder;
}

template <typename T>
bool SameBits(const Plane<T>& a, const Plane<T>& b) {
  if (a.width() != b.width() || a.height() != b.height()) {
    return false;
  }
  for (int y = 0; y < a.height(); ++y) {
    if (std::memcmp(a.Row(y), b.Row(y), sizeof(T) * static_cast<size_t>(a.width())) != 0) {
      return false;
    }
  }
  return true;
}

template <typename T, int N>
bool SameBits(const Planes<T, N>& a, const Planes<T, N>& b) {
  for (int c = 0; c < N; ++c) {
    if (!SameBits(a[c], b[c])) {
      return false;
    }
  }
  return true;
}

void ExpectSameFrame(const Frame& a, const Frame& b) {
  ASSERT_EQ(a.signals.size(), b.signals.size());
  for (size_t i = 0; i < a.signals.size(); ++i) {
    EXPECT_TRUE(SameBits(a.signals[i].radiance, b.signals[i].radiance)) << i;
    EXPECT_TRUE(SameBits(a.signals[i].second_moment, b.signals[i].second_moment)) << i;
  }
  EXPECT_TRUE(SameBits(a.guides.depth, b.guides.depth));
  EXPECT_TRUE(SameBits(a.guides.normal, b.guides.normal));
  EXPECT_TRUE(SameBits(a.guides.albedo, b.guides.albedo));
  EXPECT_TRUE(SameBits(a.guides.specular_albedo, b.guides.specular_albedo));
  EXPECT_TRUE(SameBits(a.guides.motion, b.guides.motion));
  EXPECT_TRUE(SameBits(a.guides.id, b.guides.id));
  EXPECT_TRUE(SameBits(a.emission, b.emission));
  EXPECT_TRUE(SameBits(a.background, b.background));
}

TEST(RendererTest, SameBitsWithAnyNumberOfThreads) {
  const SceneBuilder builder = VariedScene();
  RenderSettings settings = SmallSettings(150, 90, 2);
  RenderMoment moment;
  moment.frame_index = 3;
  moment.seconds = 0.4;
  moment.previous_seconds = 0.3;
  Frame one;
  Image3 reference_one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    auto renderer = Renderer::Create(builder.scene, settings);
    ASSERT_TRUE(renderer.ok());
    ASSERT_TRUE((*renderer)->RenderFrame(moment, &one).ok());
    ASSERT_TRUE((*renderer)->RenderReference(moment, 2, &reference_one).ok());
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  auto renderer = Renderer::Create(builder.scene, settings);
  ASSERT_TRUE(renderer.ok());
  Frame several;
  Image3 reference_several;
  ASSERT_TRUE((*renderer)->RenderReference(moment, 2, &reference_several).ok());
  ASSERT_TRUE((*renderer)->RenderFrame(moment, &several).ok());
  ExpectSameFrame(one, several);
  EXPECT_TRUE(SameBits(reference_one, reference_several));
}

// Mean squared difference of all values.
double MeanSquaredError(const Image3& a, const Image3& b) {
  double sum = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const glm::dvec3 d(Pixel(a, x, y) - Pixel(b, x, y));
      sum += glm::dot(d, d);
    }
  }
  return sum / (3.0 * a.width() * a.height());
}

// Many samples reach the limit with any sampler: 16 times the samples, less than a quarter of the
// squared error, against a picture with random numbers of its own.
TEST(RendererTest, ErrorFallsWithTheNumberOfSamplesWithAnySampler) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 0.5f, 3));
  builder.Add(Quad(vec3(-4, -1, 4), vec3(8, 0, 0), vec3(0, 0, -8)),
              Lambert(vec3(0.7f, 0.6f, 0.5f)));
  builder.Add(FacetedSphere(vec3(-0.5f, 0, -1), 0.8f, 2), Lambert(vec3(0.3f, 0.6f, 0.9f)));
  builder.Add(Quad(vec3(-1, 2.5f, -1), vec3(2, 0, 0), vec3(0, 0, 2)), Emitter(vec3(4.0f)));
  RenderSettings settings = SmallSettings(24, 16, 1);
  settings.seed = 1234;
  const Image3 truth = RenderMean(builder.scene, settings, 4096);
  settings.seed = 0;
  for (const SamplerKind kind :
       {SamplerKind::kSobol, SamplerKind::kHalton16, SamplerKind::kZSobol}) {
    SCOPED_TRACE(static_cast<int>(kind));
    settings.sampler = kind;
    const double few = MeanSquaredError(RenderMean(builder.scene, settings, 16), truth);
    const double many = MeanSquaredError(RenderMean(builder.scene, settings, 256), truth);
    EXPECT_LT(many, few / 4);
    settings.spp = 16;
    const Image3 short_frame = SumOfLight(RenderOne(builder.scene, settings));
    settings.spp = 256;
    const Image3 long_frame = SumOfLight(RenderOne(builder.scene, settings));
    EXPECT_LT(MeanSquaredError(long_frame, truth), MeanSquaredError(short_frame, truth) / 4);
  }
}

// Many instances of a large mesh share its triangles in the BVH, and look like copies.
TEST(RendererTest, ManyPlacesOfAMeshShareItsTriangles) {
  SceneBuilder builder;
  builder.CameraTransform() = At(vec3(0, 0, 3));
  builder.scene.environment.radiance = vec3(0.1f, 0.15f, 0.2f);
  builder.Add(FacetedSphere(vec3(0), 0.8f, 6), Lambert(vec3(0.3f, 0.6f, 0.9f)));
  const RenderSettings settings = SmallSettings(40, 30, 1);
  const Frame copied = RenderOne(builder.scene, settings);
  const size_t triangles = builder.scene.meshes.front().indices.size() / 3;
  ASSERT_GT(triangles, 10'000u);
  const size_t places = 5'000'000 / triangles;
  for (size_t i = 0; i < places; ++i) {
    const int node = builder.AddNode(At(vec3(0, 0, 10.0f + static_cast<float>(i))));
    builder.scene.instances.push_back({0, node});  // behind the camera
  }
  auto renderer = Renderer::Create(builder.scene, settings);
  ASSERT_TRUE(renderer.ok()) << renderer.status().message();
  EXPECT_LT((*renderer)->memory_bytes(), 200 * triangles + 4000 * places);
  Frame shared;
  ASSERT_TRUE((*renderer)->RenderFrame({}, &shared).ok());
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      EXPECT_FLOAT_EQ(shared.guides.depth(x, y), copied.guides.depth(x, y)) << x << ' ' << y;
      EXPECT_EQ(shared.guides.id(x, y), copied.guides.id(x, y));
      EXPECT_EQ(shared.guides.motion[0](x, y), 0.0f);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(shared.guides.normal[c](x, y), copied.guides.normal[c](x, y), 1e-5f);
      }
    }
  }
}

TEST(RendererTest, FramesDependOnTheirMomentAlone) {
  const SceneBuilder builder = VariedScene();
  auto renderer = Renderer::Create(builder.scene, SmallSettings(40, 30, 1));
  ASSERT_TRUE(renderer.ok());
  RenderMoment late;
  late.frame_index = 9;
  late.seconds = 0.9;
  late.previous_seconds = 0.8;
  Frame first;
  Frame other;
  Frame again;
  ASSERT_TRUE((*renderer)->RenderFrame(late, &first).ok());
  ASSERT_TRUE((*renderer)->RenderFrame({}, &other).ok());
  ASSERT_TRUE((*renderer)->RenderFrame(late, &again).ok());
  ExpectSameFrame(first, again);
  EXPECT_FALSE(SameBits(first.guides.depth, other.guides.depth));
}

TEST(RendererTest, SecondMomentIsThatOfSingleSamples) {
  const SceneBuilder builder = VariedScene();
  constexpr int kSamples = 4;
  RenderSettings settings = SmallSettings(48, 32, kSamples);
  settings.sampler = SamplerKind::kSobol;  // whose points do not depend on their number per frame
  const Frame frame = RenderOne(builder.scene, settings);
  settings.spp = 1;
  ASSERT_EQ(frame.samples(7, 7), kSamples);
  // Without jitter and movement, frame i of one sample draws sample i of the big frame.
  Image1 sums[kTracedSignalCount];
  for (Image1& sum : sums) {
    sum = Image1(48, 32);
  }
  for (int i = 0; i < kSamples; ++i) {
    RenderMoment moment;
    moment.frame_index = i;
    const Frame single = RenderOne(builder.scene, settings, moment);
    EXPECT_TRUE(single.samples.empty());
    for (int k = 0; k < kTracedSignalCount; ++k) {
      const Signal& signal = single.signals[static_cast<size_t>(k)];
      EXPECT_TRUE(signal.second_moment.empty());
      const bool diffuse =
          signal.kind == SignalKind::kDirectDiffuse || signal.kind == SignalKind::kIndirectDiffuse;
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 48; ++x) {
          const vec3 albedo =
              Pixel(diffuse ? single.guides.albedo : single.guides.specular_albedo, x, y);
          sums[k](x, y) +=
              std::pow(Luminance709(Demodulate(Pixel(signal.radiance, x, y), albedo)), 2.0f);
        }
      }
    }
  }
  double total = 0;
  for (int k = 0; k < kTracedSignalCount; ++k) {
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 48; ++x) {
        const float expected = sums[k](x, y) / kSamples;
        total += expected;
        ASSERT_NEAR(frame.signals[static_cast<size_t>(k)].second_moment(x, y), expected,
                    1e-5f * expected)
            << k << ' ' << x << ' ' << y;
      }
    }
  }
  EXPECT_GT(total, 0.0);
}

TEST(RendererTest, FramesAddUpToTheReference) {
  const SceneBuilder builder = VariedScene();
  RenderSettings settings = SmallSettings(24, 16, 4);
  const vec3 reference = Mean(RenderMean(builder.scene, settings, 256));
  auto renderer = Renderer::Create(builder.scene, settings);
  ASSERT_TRUE(renderer.ok());
  vec3 mean(0.0f);
  constexpr int kFrames = 64;
  for (int i = 0; i < kFrames; ++i) {
    RenderMoment moment;
    moment.frame_index = i;
    Frame frame;
    ASSERT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
    mean += Mean(SumOfLight(frame)) / static_cast<float>(kFrames);
  }
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean[c] / reference[c], 1.0f, 0.02f) << c;
  }
}

TEST(RendererTest, ErrorFallsFasterThanOneOverTheRoot) {
  // Low-discrepancy frames: 64 frames are more than 8 times better than one.
  SceneBuilder builder;
  builder.Add(Quad(vec3(-4, -1, 0), vec3(8, 0, 0), vec3(0, 0, -8)), Lambert(vec3(0.5f)));
  builder.Add(Quad(vec3(-2, 1.5f, -5), vec3(4, 0, 0), vec3(0, 0, 3)), Emitter(vec3(1.0f)));
  RenderSettings settings = SmallSettings(24, 18, 1);
  settings.bounces = 1;
  const Image3 truth = RenderMean(builder.scene, settings, 2048);
  const auto error = [&](int spp) {
    settings.spp = spp;
    const Image3 image = SumOfLight(RenderOne(builder.scene, settings));
    double sum = 0;
    for (int y = 0; y < 18; ++y) {
      for (int x = 0; x < 24; ++x) {
        sum += std::pow(Pixel(image, x, y).x - Pixel(truth, x, y).x, 2.0);
      }
    }
    return std::sqrt(sum);
  };
  EXPECT_LT(error(64), error(1) / 10);
}

TEST(RendererTest, CancellingLeavesARendererThatWorks) {
  const SceneBuilder builder = VariedScene();
  auto renderer = Renderer::Create(builder.scene, SmallSettings(100, 70, 1));
  ASSERT_TRUE(renderer.ok());
  Frame expected;
  ASSERT_TRUE((*renderer)->RenderFrame({}, &expected).ok());
  double last = 0;
  int calls = 0;
  const Status status = (*renderer)->RenderFrame({}, &expected, [&](double fraction) {
    EXPECT_GT(fraction, last);
    last = fraction;
    return ++calls < 3;
  });
  EXPECT_EQ(status.code(), StatusCode::kCancelled);
  EXPECT_EQ(calls, 3);
  Image3 reference;
  EXPECT_EQ((*renderer)->RenderReference({}, 2, &reference, [](double) { return false; }).code(),
            StatusCode::kCancelled);
  Frame again;
  Frame fresh = RenderOne(builder.scene, SmallSettings(100, 70, 1));
  ASSERT_TRUE((*renderer)
                  ->RenderFrame({}, &again,
                                [&](double fraction) {
                                  last = fraction;
                                  return true;
                                })
                  .ok());
  EXPECT_DOUBLE_EQ(last, 1.0);
  ExpectSameFrame(again, fresh);
}

TEST(RendererTest, TimingsCountRays) {
  const SceneBuilder builder = VariedScene();
  auto renderer = Renderer::Create(builder.scene, SmallSettings(40, 30, 1));
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  ASSERT_TRUE((*renderer)->RenderFrame({}, &frame).ok());
  const RenderTimings& timings = (*renderer)->timings();
  EXPECT_GE(timings.primary_rays, 1200u);
  EXPECT_GT(timings.bounce_rays, 500u);
  EXPECT_GT(timings.shadow_rays, 500u);
  EXPECT_GT(timings.shade_ms, 0.0);
  EXPECT_EQ(timings.dropped, 0u);
  EXPECT_GT((*renderer)->memory_bytes(), 10000u);
}

TEST(RendererTest, FlattenedTransformsMirrorAndVanish) {
  SceneBuilder builder;
  const int quad = builder.Add(Quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0)),
                               Emitter(vec3(1.0f)), At(vec3(0, 0, -2)));
  Transform& transform = builder.scene.nodes[static_cast<size_t>(builder.InstanceNode(quad))].local;
  transform.scale = vec3(-1, 1, 1);  // mirrored: still seen from the front
  EXPECT_NEAR(Mean(RenderOne(builder.scene, SmallSettings(2, 2, 1)).emission).x, 1.0f, 1e-6f);
  // Shrinking to nothing in the course of an animation.
  AnimationChannel shrink;
  shrink.node = builder.InstanceNode(quad);
  shrink.property = AnimatedProperty::kScale;
  shrink.times = {0.0f, 1.0f};
  shrink.values = {vec4(1.0f), vec4(0.0f)};
  builder.scene.animation.push_back(shrink);
  auto renderer = Renderer::Create(builder.scene, SmallSettings(2, 2, 1));
  ASSERT_TRUE(renderer.ok());
  for (const double seconds : {1.0, 0.0, 1.0}) {
    RenderMoment moment;
    moment.seconds = moment.previous_seconds = seconds;
    Frame frame;
    ASSERT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
    EXPECT_NEAR(Mean(frame.emission).x, seconds > 0 ? 0.0f : 1.0f, 1e-6f);
  }
}

bool SameLightAndDepth(const Frame& a, const Frame& b) {
  bool same =
      SameBits(a.guides.depth, b.guides.depth) && a.reflection.empty() == b.reflection.empty();
  for (size_t i = 0; i < a.signals.size(); ++i) {
    same = same && SameBits(a.signals[i].radiance, b.signals[i].radiance);
  }
  return same;
}

TEST(RendererTest, EverySettingChangesTheFrame) {
  const SceneBuilder builder = VariedScene();
  RenderMoment moment;
  moment.frame_index = 3;
  for (const Parameter& p : RenderParameters()) {
    RenderSettings settings;
    settings.width = 60;
    settings.height = 40;
    settings.cycle = std::string(p.name) == "guides" ? 8 : 1;  // without effect at 1
    if (std::string(p.group) == "lens" && std::string(p.name) != "aperture") {
      settings.aperture = 0.5f;  // without which they have no effect
      settings.blades = 5;
    }
    const Frame before = RenderOne(builder.scene, settings, moment);
    EXPECT_TRUE(SameLightAndDepth(before, RenderOne(builder.scene, settings, moment)));
    ASSERT_TRUE(SetRenderParameter(&settings, p.name, test::OtherValue(p)).ok());
    EXPECT_FALSE(SameLightAndDepth(before, RenderOne(builder.scene, settings, moment))) << p.name;
  }
}

TEST(RendererTest, InvalidSettingsAreNamed) {
  const SceneBuilder builder = VariedScene();
  const auto message = [&](auto change) {
    RenderSettings settings = SmallSettings(8, 8, 1);
    change(&settings);
    auto renderer = Renderer::Create(builder.scene, settings);
    EXPECT_FALSE(renderer.ok());
    EXPECT_EQ(renderer.status().code(), StatusCode::kInvalidArgument);
    return renderer.status().message();
  };
  EXPECT_THAT(message([](RenderSettings* s) { s->width = 0; }), HasSubstr("width is 0"));
  EXPECT_THAT(message([](RenderSettings* s) { s->height = 40000; }), HasSubstr("height is 40000"));
  EXPECT_THAT(message([](RenderSettings* s) { s->spp = 0; }), HasSubstr("spp is '0'"));
  EXPECT_THAT(message([](RenderSettings* s) { s->bounces = 33; }), HasSubstr("bounces is '33'"));
  EXPECT_THAT(message([](RenderSettings* s) { s->sampler = static_cast<SamplerKind>(7); }),
              HasSubstr("sampler is '7', expected one of sobol, halton16, zsobol"));
}

TEST(RendererTest, InvalidMomentsAndArgumentsAreNamed) {
  const SceneBuilder builder = VariedScene();
  auto renderer = Renderer::Create(builder.scene, SmallSettings(8, 8, 1));
  ASSERT_TRUE(renderer.ok());
  Frame frame;
  RenderMoment moment;
  moment.camera = 1;
  EXPECT_THAT((*renderer)->RenderFrame(moment, &frame).message(), HasSubstr("camera is 1"));
  moment.camera = 0;
  moment.seconds = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT((*renderer)->RenderFrame(moment, &frame).message(), HasSubstr("seconds is nan"));
  Image3 image;
  EXPECT_THAT((*renderer)->RenderReference({}, 0, &image).message(), HasSubstr("spp"));
  EXPECT_FALSE((*renderer)->RenderFrame({}, nullptr).ok());
  EXPECT_FALSE((*renderer)->RenderReference({}, 1, nullptr).ok());
}

TEST(RendererTest, InvalidScenesAreNamed) {
  const auto message = [&](auto change) {
    SceneBuilder builder = VariedScene();
    change(&builder.scene);
    auto renderer = Renderer::Create(builder.scene, SmallSettings(8, 8, 1));
    EXPECT_FALSE(renderer.ok());
    return renderer.status().message();
  };
  EXPECT_THAT(message([](Scene* s) { s->meshes[0].indices[3] = 99; }), HasSubstr("index 99"));
  EXPECT_THAT(message([](Scene* s) { s->meshes[0].normals.pop_back(); }), HasSubstr("3 normals"));
  EXPECT_THAT(message([](Scene* s) { s->meshes[1].material = -1; }), HasSubstr("mesh 1"));
  EXPECT_THAT(message([](Scene* s) { s->instances[2].node = 77; }), HasSubstr("instance 2"));
  EXPECT_THAT(message([](Scene* s) { s->nodes[1].parent = 3; }), HasSubstr("node 1"));
  EXPECT_THAT(message([](Scene* s) { s->materials[1].ior = 0.5f; }), HasSubstr("ior is 0.5"));
  EXPECT_THAT(message([](Scene* s) { s->materials[0].base_color_texture.texture = 7; }),
              HasSubstr("base colour texture"));
  EXPECT_THAT(message([](Scene* s) { s->environment.radiance.x = -1.0f; }),
              HasSubstr("environment"));
  EXPECT_THAT(message([](Scene* s) {
                s->environment.map = Image3(2, 1);
                s->environment.map[1](1, 0) = std::numeric_limits<float>::infinity();
              }),
              HasSubstr("pixel (1, 0)"));
}

TEST(RendererTest, EmptySceneShowsItsEnvironment) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(0.5f);
  EXPECT_EQ(Mean(RenderOne(builder.scene, SmallSettings(3, 5, 1)).background), vec3(0.5f));
}

TEST(RendererTest, TextureCoordinatesOfAnySizeAreSafe) {
  SceneBuilder builder;
  Texture texture;
  texture.width = texture.height = 2;
  texture.texels.assign(16, 128);
  builder.scene.textures.push_back(texture);
  Material material = Lambert(vec3(1.0f));
  material.base_color_texture.texture = 0;
  Mesh quad = Quad(vec3(-9, -9, -3), vec3(18, 0, 0), vec3(0, 18, 0));
  quad.uv[0] = {vec2(0, -1e30f), vec2(1e30f, 0), vec2(std::numeric_limits<float>::quiet_NaN(), 0),
                vec2(-5, 1e9f)};
  builder.Add(quad, material);
  builder.scene.environment.radiance = vec3(1.0f);
  const Frame frame = RenderOne(builder.scene, SmallSettings(8, 8, 1));
  EXPECT_NEAR(frame.guides.albedo[0](2, 5), SrgbDecode(128.0f / 255), 1e-5f);
}

// The last ray of a path is left out where it can meet no emitter. A transmissive material, even
// one that nothing is made of, keeps the renderer from relying on that: the picture stays the same.
TEST(LastRayTest, LeavingItOutChangesNothing) {
  for (const std::string& name : BuiltinSceneNames()) {
    Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    const bool glass = std::any_of(scene->materials.begin(), scene->materials.end(),
                                   [](const Material& m) { return m.transmission > 0.0f; });
    RenderSettings settings;
    settings.width = 120;
    settings.height = 68;
    settings.bounces = 2;
    settings.virtual_guides = false;  // glass would have signals of its own
    const auto render = [&](uint64_t* bounce_rays) {
      Result<std::unique_ptr<Renderer>> renderer = Renderer::Create(*scene, settings);
      EXPECT_TRUE(renderer.ok());
      Frame frame;
      EXPECT_TRUE((*renderer)->RenderFrame(RenderMoment(), &frame).ok());
      *bounce_rays = (*renderer)->timings().bounce_rays;
      return frame;
    };
    uint64_t with = 0;
    uint64_t without = 0;
    const Frame left_out = render(&without);
    Material unused;
    unused.transmission = 1.0f;
    scene->materials.push_back(unused);
    const Frame all = render(&with);
    ExpectSameFrame(left_out, all);
    const bool lit_from_outside = scene->environment.radiance != vec3(0.0f);
    if (!glass && !lit_from_outside) {
      EXPECT_LT(without, with * 8 / 10) << name;
    } else {
      EXPECT_EQ(without, with) << name;
    }
  }
}

TEST(RendererTest, PreparingASceneCanBeStopped) {
  SceneBuilder builder;
  for (int i = 0; i < 10; ++i) {
    builder.Add(Quad(vec3(-1, -1, -5 - i), vec3(2, 0, 0), vec3(0, 2, 0)), Lambert(vec3(0.5f)));
  }
  int stopped = 0;
  for (int stop_at = 1;; ++stop_at) {
    std::atomic<int> calls{0};
    const auto renderer = Renderer::Create(builder.scene, SmallSettings(4, 4, 1),
                                           [&] { return calls.fetch_add(1) + 1 < stop_at; });
    if (renderer.ok()) {
      break;
    }
    ASSERT_EQ(renderer.status().code(), StatusCode::kCancelled) << renderer.status().message();
    ++stopped;
  }
  EXPECT_GE(stopped, 10);
}

}  // namespace
}  // namespace stillray::render::renderer_test
