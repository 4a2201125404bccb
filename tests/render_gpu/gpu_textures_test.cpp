// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Textures in an atlas: where they are, and what texture units and the exact way read from them.
#include "render/vulkan/texture_atlas.h"

#include <gmock/gmock.h>

#include "core/colour.h"
#include "render/deforming_scene.h"
#include "render/test_scenes.h"
#include "render/texture.h"
#include "render/texture_shared.h"
#include "render/vulkan/vulkan_renderer.h"
#include "render_gpu/everything_scene.h"
#include "render_gpu/gpu_batch.h"
#include "render_gpu/run_shader.h"
#include "render_gpu/textures_shared.h"
#include "render_gpu/tracing_ways.h"

namespace stillray::render {
namespace shaders {
extern const std::uint32_t kTextures[];
extern const std::size_t kTexturesWords;
}  // namespace shaders

namespace {

using ::testing::HasSubstr;

// Texture units round the fractions between texels to 8 bits, along each axis, and their results:
// so much of the contrast of the four texels, and of 1.
constexpr float kOfContrast = 2.0f / 256.0f;
constexpr float kOfOne = 1.0f / 255.0f;

Texture RandomTexture(int width, int height, uint32_t seed, Wrap wrap_u = Wrap::kRepeat,
                      Wrap wrap_v = Wrap::kRepeat, bool nearest = false) {
  Texture texture;
  texture.width = width;
  texture.height = height;
  texture.wrap_u = wrap_u;
  texture.wrap_v = wrap_v;
  texture.nearest = nearest;
  for (int i = 0; i < 4 * width * height; ++i) {
    texture.texels.push_back(static_cast<uint8_t>(HashCombine(seed, static_cast<uint32_t>(i))));
  }
  return texture;
}

// Every way to wrap, odd sizes, a single texel, single rows and columns.
std::vector<Texture> AllKinds() {
  std::vector<Texture> textures;
  uint32_t seed = 1;
  for (const Wrap u : {Wrap::kRepeat, Wrap::kMirror, Wrap::kClamp}) {
    for (const Wrap v : {Wrap::kRepeat, Wrap::kMirror, Wrap::kClamp}) {
      for (const auto& [width, height] :
           {std::pair{16, 16}, {7, 13}, {1, 1}, {1, 9}, {33, 1}, {64, 5}}) {
        ++seed;
        textures.push_back(RandomTexture(width, height, seed, u, v, seed % 4 == 0));
      }
    }
  }
  return textures;
}

// The value of the four texels around a place, as far as it may be rounded.
struct Expected {
  vec4 value;
  vec4 contrast;
};

Expected ExpectedAt(const Texture& texture, vec2 uv, TexelEncoding encoding) {
  Expected e = {SampleTexture(texture, uv, encoding), vec4(0)};
  if (texture.nearest) {
    return e;
  }
  Texture nearest = texture;
  nearest.nearest = true;
  const vec2 texel(1.0f / static_cast<float>(texture.width),
                   1.0f / static_cast<float>(texture.height));
  vec4 least(1);
  vec4 most(0);
  for (int corner = 0; corner < 4; ++corner) {
    const vec2 step((corner & 1) != 0 ? 0.5f : -0.5f, (corner & 2) != 0 ? 0.5f : -0.5f);
    const vec4 value = SampleTexture(nearest, uv + step * texel, encoding);
    least = glm::min(least, value);
    most = glm::max(most, value);
  }
  e.contrast = most - least;
  return e;
}

// Bilinear in a copy with a border, as texture units compute it, without their rounding.
vec4 SampleBordered(const Texture& texture, vec2 uv) {
  const float x =
      WrapCoordinate(uv.x * static_cast<float>(texture.width), static_cast<float>(texture.width),
                     static_cast<int>(texture.wrap_u)) -
      0.5f;
  const float y =
      WrapCoordinate(uv.y * static_cast<float>(texture.height), static_cast<float>(texture.height),
                     static_cast<int>(texture.wrap_v)) -
      0.5f;
  const int left = FloorToInt(x);
  const int top = FloorToInt(y);
  EXPECT_TRUE(left >= -1 && left < texture.width && top >= -1 && top < texture.height);
  const auto texel = [&](int dx, int dy) {
    const uint32_t t = BorderedTexel(texture, left + dx, top + dy);
    return vec4(t & 255u, t >> 8 & 255u, t >> 16 & 255u, t >> 24) / 255.0f;
  };
  const float fx = x - static_cast<float>(left);
  const float fy = y - static_cast<float>(top);
  return glm::mix(glm::mix(texel(0, 0), texel(1, 0), fx), glm::mix(texel(0, 1), texel(1, 1), fx),
                  fy);
}

// In and far outside of the texture, on texels' edges and centres.
std::vector<TextureLookup> Lookups(const std::vector<Texture>& textures) {
  std::vector<TextureLookup> lookups;
  for (uint32_t t = 0; t < textures.size(); ++t) {
    for (uint32_t i = 0; i < 400; ++i) {
      const uint32_t h = HashCombine(t, i);
      vec2 uv(UniformFloat(HashCombine(h, 1)), UniformFloat(HashCombine(h, 2)));
      const float range = i % 4 == 0 ? 1.0f : (i % 4 == 1 ? 9.0f : 3.0f);
      uv = (uv - vec2(0.5f)) * range;
      if (i % 5 == 0) {
        const vec2 size(textures[t].width, textures[t].height);
        uv = (glm::floor(uv * size) + vec2(i % 2 == 0 ? 0.5f : 0.0f)) / size;
      }
      lookups.push_back({uv, t, i % 3 == 0 ? 1u : 0u});
    }
  }
  return lookups;
}

TEST(TextureAtlas, TexturesDoNotOverlapAndLieInside) {
  for (const int most_size : {128, 4096}) {
    for (const int count : {1, 2, 5, 300}) {
      std::vector<Texture> textures(static_cast<size_t>(count));
      for (uint32_t i = 0; i < textures.size(); ++i) {
        textures[i].width = 1 + static_cast<int>(HashCombine(i, 1) % 100);
        textures[i].height = 1 + static_cast<int>(HashCombine(i, 2) % 60);
      }
      const Result<TextureAtlas> atlas = PlanAtlas(textures, most_size, 2048);
      ASSERT_TRUE(atlas.ok()) << atlas.status().message();
      EXPECT_LE(std::max(atlas->width, atlas->height), most_size);
      ASSERT_EQ(atlas->places.size(), textures.size());
      const size_t layer = static_cast<size_t>(atlas->width) * static_cast<size_t>(atlas->height);
      std::vector<int> taken(layer * static_cast<size_t>(atlas->layers), 0);
      size_t texels = 0;
      for (size_t i = 0; i < textures.size(); ++i) {
        const AtlasPlace& p = atlas->places[i];
        ASSERT_GE(std::min(p.x, p.y), 1u);
        ASSERT_LE(p.x + static_cast<uint32_t>(textures[i].width) + 1,
                  static_cast<uint32_t>(atlas->width));
        ASSERT_LE(p.y + static_cast<uint32_t>(textures[i].height) + 1,
                  static_cast<uint32_t>(atlas->height));
        ASSERT_LT(p.layer, static_cast<uint32_t>(atlas->layers));
        for (uint32_t y = p.y - 1; y <= p.y + static_cast<uint32_t>(textures[i].height); ++y) {
          for (uint32_t x = p.x - 1; x <= p.x + static_cast<uint32_t>(textures[i].width); ++x) {
            ++taken[p.layer * layer + y * static_cast<size_t>(atlas->width) + x];
            ++texels;
          }
        }
      }
      EXPECT_LE(*std::max_element(taken.begin(), taken.end()), 1);
      // Little is left free where there are many.
      EXPECT_TRUE(count < 300 || taken.size() < 2 * texels) << taken.size() << " for " << texels;
    }
  }
}

TEST(TextureAtlas, SaysWhatDoesNotFit) {
  Texture wide;
  wide.width = 127;
  wide.height = 2;
  Result<TextureAtlas> atlas = PlanAtlas({wide}, 128, 2048);
  ASSERT_FALSE(atlas.ok());
  EXPECT_EQ(atlas.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(atlas.status().message(),
              HasSubstr("the 1 textures of the scene, of up to 127x2 texels, do not fit into "
                        "images of 128x128 with 2048 layers"));
  wide.width = 126;
  EXPECT_TRUE(PlanAtlas({wide}, 128, 2048).ok());
  wide.height = 126;
  EXPECT_TRUE(PlanAtlas({wide, wide}, 128, 2).ok());
  EXPECT_FALSE(PlanAtlas({wide, wide, wide}, 128, 2).ok());
  EXPECT_EQ(PlanAtlas({}, 128, 2)->layers, 1);
}

TEST(TextureAtlas, BordersMakeBilinearFilteringRightAtEdges) {
  const std::vector<Texture> textures = AllKinds();
  for (const TextureLookup& lookup : Lookups(textures)) {
    Texture texture = textures[lookup.texture_number];
    texture.nearest = false;
    const vec4 expected = SampleTexture(texture, lookup.uv, TexelEncoding::kLinear);
    const vec4 found = SampleBordered(texture, lookup.uv);
    for (int k = 0; k < 4; ++k) {
      ASSERT_NEAR(found[k], expected[k], 1e-4f)
          << lookup.texture_number << " at " << lookup.uv.x << ", " << lookup.uv.y;
    }
  }
}

class GpuTexturesTest : public TracingWaysTest {
 protected:
  // What textures.comp reads from the textures of a scene.
  std::vector<vec4> Read(const std::vector<Texture>& textures, TextureWay way,
                         const std::vector<TextureLookup>& lookups) {
    SceneBuilder builder;
    builder.scene.textures = textures;
    SceneState state(builder.scene);
    state.Update(0, 0);
    const auto accel = GpuAccel::Create(device_.get(), state, GetParam(), way);
    EXPECT_TRUE(accel.ok()) << accel.status().message();
    EXPECT_EQ((*accel)->samples_textures(), way == TextureWay::kSampled);
    return RunShader<vec4>(device_.get(),
                           {.name = "textures",
                            .code = {shaders::kTextures, shaders::kTexturesWords},
                            .own_set = 1,
                            .other_shape = GpuAccel::kSceneShape,
                            .other_set = (*accel)->scene_set(),
                            .constants = (*accel)->constants()},
                           lookups);
  }

  Frame Render(const Scene& scene, const RenderSettings& settings, TextureWay textures,
               TracingWay way) {
    Frame frame;
    const auto renderer =
        CreateVulkanRenderer(scene, settings, device_, {.way = way, .textures = textures});
    EXPECT_TRUE(renderer.ok()) << renderer.status().message();
    RenderMoment moment;
    moment.seconds = 0.5;
    moment.previous_seconds = 0.5;
    EXPECT_TRUE((*renderer)->RenderFrame(moment, &frame).ok());
    return frame;
  }

  std::vector<vec3> Transmittance(const SceneState& state, const std::vector<GpuRay>& rays,
                                  TextureWay textures, TracingWay way) {
    auto accel = GpuAccel::Create(device_.get(), state, way, textures);
    EXPECT_TRUE(accel.ok()) << accel.status().message();
    GpuBatch batch(device_.get(), accel->get(), static_cast<uint32_t>(rays.size()));
    return batch.Transmittance(rays);
  }
};

TEST_P(GpuTexturesTest, ExactLookupsAreTheCpusAndSampledOnesAreWithinTheRoundingOfTextureUnits) {
  const std::vector<Texture> textures = AllKinds();
  const std::vector<TextureLookup> lookups = Lookups(textures);
  const std::vector<vec4> exact = Read(textures, TextureWay::kExact, lookups);
  const std::vector<vec4> sampled = Read(textures, TextureWay::kSampled, lookups);
  float furthest = 0;
  for (size_t i = 0; i < lookups.size(); ++i) {
    const Texture& texture = textures[lookups[i].texture_number];
    const auto encoding = lookups[i].srgb != 0 ? TexelEncoding::kSrgb : TexelEncoding::kLinear;
    const Expected e = ExpectedAt(texture, lookups[i].uv, encoding);
    for (int k = 0; k < 4; ++k) {
      ASSERT_NEAR(exact[i][k], e.value[k], 1e-4f) << i;
      const float off = std::abs(sampled[i][k] - e.value[k]);
      ASSERT_LE(off, kOfOne + kOfContrast * e.contrast[k])
          << i << ", texture " << lookups[i].texture_number << " at " << lookups[i].uv.x << ", "
          << lookups[i].uv.y;
      furthest = std::max(furthest, off);
    }
  }
  test::RecordLargest("difference of a sampled texel", furthest, kOfOne + kOfContrast);
  EXPECT_GT(furthest, 0.0f);  // it is another way
}

TEST_P(GpuTexturesTest, TexturesOfManyLayersAndLargerThanAPieceAreUploaded) {
  std::vector<Texture> textures;
  for (uint32_t i = 0; i < 9; ++i) {
    textures.push_back(RandomTexture(2040, 300 + 100 * static_cast<int>(i), i));
  }
  textures.push_back(RandomTexture(3000, 3000, 77));  // 34 MiB
  const Result<TextureAtlas> atlas = PlanAtlas(textures, 16384, 2048);
  ASSERT_TRUE(atlas.ok());
  EXPECT_GT(atlas->layers, 1);
  std::vector<TextureLookup> lookups;
  for (uint32_t i = 0; i < 4096; ++i) {
    const uint32_t number = i % static_cast<uint32_t>(textures.size());
    const Texture& t = textures[number];
    const vec2 size(t.width, t.height);
    const vec2 uv(UniformFloat(HashCombine(i, 1)), UniformFloat(HashCombine(i, 2)));
    // Centres of texels: exact but for the rounding of the result.
    lookups.push_back({(glm::floor(uv * size) + vec2(0.5f)) / size, number, 0});
  }
  const std::vector<vec4> sampled = Read(textures, TextureWay::kSampled, lookups);
  for (size_t i = 0; i < lookups.size(); ++i) {
    const vec4 expected =
        SampleTexture(textures[lookups[i].texture_number], lookups[i].uv, TexelEncoding::kLinear);
    for (int k = 0; k < 4; ++k) {
      ASSERT_NEAR(sampled[i][k], expected[k], kOfOne + kOfContrast) << i;
    }
  }
}

// Albedo of pixels, and their light, of frames that differ by nothing else. A path takes another
// way where the texel decides it: at the edge of a cut-out, or in the choice of a lobe.
TEST_P(GpuTexturesTest, FramesAreTheExactOnes) {
  LeaveValidation();
  Scene scene = EverythingScene();
  scene.environment.radiance = vec3(0.4f, 0.5f, 0.7f);
  RenderSettings settings = SmallSettings(73, 45, 1);
  settings.bounces = 1;
  settings.virtual_guides = false;
  const Frame exact = Render(scene, settings, TextureWay::kExact, GetParam());
  const Frame sampled = Render(scene, settings, TextureWay::kSampled, GetParam());
  const double mean = Luminance709(Mean(SumOfLight(exact)));
  int albedo = 0;
  int light = 0;
  int same = 0;
  for (int y = 0; y < exact.height; ++y) {
    for (int x = 0; x < exact.width; ++x) {
      const vec3 a = Pixel(exact.guides.albedo, x, y);
      const vec3 b = Pixel(sampled.guides.albedo, x, y);
      albedo += MaxComponent(abs(a - b)) > 0.02f ? 1 : 0;
      same += a == b ? 1 : 0;
      bool differs = false;
      for (size_t k = 0; k < exact.signals.size(); ++k) {
        const vec3 e = Pixel(exact.signals[k].radiance, x, y);
        const vec3 s = Pixel(sampled.signals[k].radiance, x, y);
        differs = differs || MaxComponent(abs(e - s)) > 0.02 * (mean + MaxComponent(e));
      }
      light += differs ? 1 : 0;
    }
  }
  const int pixels = exact.width * exact.height;
  EXPECT_LT(same, pixels);
  test::RecordLargest("pixels with another albedo", albedo, pixels / 100);
  EXPECT_LE(albedo, pixels / 100);
  test::RecordLargest("pixels with another light", light, pixels * 4 / 100);
  EXPECT_LE(light, pixels * 4 / 100);
  const double sampled_mean = Luminance709(Mean(SumOfLight(sampled)));
  EXPECT_NEAR(sampled_mean, mean, 0.01 * mean);
}

TEST_P(GpuTexturesTest, CutOutsAreAlikeInBothWaysOfTracing) {
  SceneBuilder builder;
  builder.scene.textures = {RandomTexture(16, 16, 5)};
  Material leaf = Lambert(vec3(0.8f));
  leaf.base_color_texture.texture = 0;
  leaf.alpha_mode = AlphaMode::kMask;
  leaf.alpha_cutoff = 0.5f;
  builder.Add(Quad(vec3(-2, -2, 0), vec3(4, 0, 0), vec3(0, 4, 0)), leaf);
  SceneState state(builder.scene);
  state.Update(0, 0);
  std::vector<GpuRay> rays = RandomRays({vec3(-2, -2, 1), vec3(2, 2, 1)}, 20000, 3, 10.0f);
  for (GpuRay& ray : rays) {
    ray.direction = vec3(0, 0, -1);
  }
  const std::vector<vec3> exact = Transmittance(state, rays, TextureWay::kExact, GetParam());
  const std::vector<vec3> sampled = Transmittance(state, rays, TextureWay::kSampled, GetParam());
  const std::vector<vec3> compute =
      Transmittance(state, rays, TextureWay::kSampled, TracingWay::kCompute);
  int moved = 0;
  int different = 0;
  int open = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    moved += exact[i] != sampled[i] ? 1 : 0;
    different += compute[i] != sampled[i] ? 1 : 0;
    open += sampled[i].x > 0.5f ? 1 : 0;
  }
  EXPECT_GT(open, 4000);
  EXPECT_LT(open, 16000);
  // The edge of a cut-out moves by fractions of a texel.
  test::RecordLargest("rays at edges of cut-outs", moved, 300);
  EXPECT_LE(moved, 300);
  EXPECT_LE(different, 2);
}

TEST_P(GpuTexturesTest, DemandedButTooLargeIsAnErrorAndByDefaultExact) {
  SceneBuilder builder;
  builder.scene.textures = {RandomTexture(100, 100, 1)};
  SceneState state(builder.scene);
  state.Update(0, 0);
  auto& limits = const_cast<VkPhysicalDeviceLimits&>(device_->context().limits);
  const VkPhysicalDeviceLimits real = limits;
  limits.maxImageDimension2D = 64;
  const auto demanded = GpuAccel::Create(device_.get(), state, GetParam(), TextureWay::kSampled);
  ASSERT_FALSE(demanded.ok());
  EXPECT_EQ(demanded.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(demanded.status().message(), HasSubstr(device_->info().name + ": the 1 textures"));
  const auto by_default = GpuAccel::Create(device_.get(), state, GetParam(), TextureWay::kAuto);
  ASSERT_TRUE(by_default.ok());
  EXPECT_FALSE((*by_default)->samples_textures());
  limits = real;
  const auto fits = GpuAccel::Create(device_.get(), state, GetParam(), TextureWay::kAuto);
  ASSERT_TRUE(fits.ok());
  EXPECT_EQ((*fits)->samples_textures(), device_->info().is_gpu);
}

STILLRAY_IN_BOTH_WAYS(GpuTexturesTest);

}  // namespace
}  // namespace stillray::render
