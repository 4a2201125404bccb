// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Guides that the device finds are those of the tracer on the CPU.
#include "render/vulkan/gpu_guides.h"

#include <gmock/gmock.h>

#include <cstring>

#include "core/random.h"
#include "gpu/vulkan_test.h"
#include "render/test_scenes.h"

namespace stillray::render {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 193;
constexpr int kHeight = 109;

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

class GpuGuidesTest : public test::VulkanTest {
 protected:
  // The guides of the scene's first camera at `moment`.
  std::vector<GpuGuides> Find(const Scene& scene, const RenderMoment& moment, int width,
                              int height) {
    SceneState state(scene);
    state.Update(0, 0);
    auto accel = GpuAccel::Create(device_.get(), state);
    EXPECT_TRUE(accel.ok()) << accel.status().message();
    auto finder = GpuGuideFinder::Create(device_.get(), accel->get());
    EXPECT_TRUE(finder.ok()) << finder.status().message();
    state.Update(moment.seconds, moment.previous_seconds);
    EXPECT_TRUE((*accel)->Update().ok());
    const Camera& camera = scene.cameras[0];
    const auto node = static_cast<size_t>(camera.node);
    const CameraView view = MakeCameraView(camera, state.nodes()[node], width, height);
    const CameraView previous = MakeCameraView(camera, state.previous_nodes()[node], width, height);
    std::vector<GpuGuides> guides(static_cast<size_t>(width) * static_cast<size_t>(height));
    const Status status = Run(accel->get(), finder->get(), view, previous, &guides);
    EXPECT_TRUE(status.ok()) << status.message();
    return guides;
  }

  Status Run(GpuAccel* accel, GpuGuideFinder* finder, const CameraView& view,
             const CameraView& previous, std::vector<GpuGuides>* guides) {
    const gpu::DeviceContext& c = device_->context();
    gpu::Arena arena(&c);
    const size_t bytes = guides->size() * sizeof(GpuGuides);
    const gpu::Buffer* target =
        *arena.AddBuffer(bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, gpu::BufferPlace::kDownload);
    STILLRAY_RETURN_IF_ERROR(arena.Allocate());
    const Result<VkCommandBuffer> commands = device_->Begin();
    accel->RecordUpdate(*commands);
    const Status recorded = finder->Record(*commands, view, previous, vec2(0.0f), *target);
    VkMemoryBarrier barrier = {};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
    c.vk.CmdPipelineBarrier(*commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                            VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0, nullptr);
    STILLRAY_RETURN_IF_ERROR(device_->Run());
    STILLRAY_RETURN_IF_ERROR(recorded);
    STILLRAY_RETURN_IF_ERROR(arena.Invalidate());
    std::memcpy(static_cast<void*>(guides->data()), target->mapped, bytes);
    return Status::Ok();
  }

  void ExpectTheCpus(const Scene& scene, double seconds, double previous_seconds) {
    RenderMoment moment;
    moment.seconds = seconds;
    moment.previous_seconds = previous_seconds;
    const Frame frame = RenderOne(scene, SmallSettings(kWidth, kHeight, 1), moment);
    const std::vector<GpuGuides> found = Find(scene, moment, kWidth, kHeight);
    struct Count {
      const char* what;
      int wrong = 0;
    };
    Count depth{"depth"}, normal{"normal"}, albedo{"albedo"}, specular{"specular albedo"};
    Count emission{"emission"}, motion{"motion"}, id{"id"}, roughness{"roughness"};
    int seen = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const GpuGuides& g = found[static_cast<size_t>(y * kWidth + x)];
        const Guides& e = frame.guides;
        seen += e.id(x, y) != 0 ? 1 : 0;
        double of_normal = 0, of_albedo = 0, of_specular = 0, of_emission = 0;
        for (int k = 0; k < 3; ++k) {
          of_normal = std::max(of_normal, Off(g.normal[k], e.normal[k](x, y)));
          of_albedo = std::max(of_albedo, Off(g.albedo[k], e.albedo[k](x, y)));
          of_specular =
              std::max(of_specular, Off(g.specular_albedo[k], e.specular_albedo[k](x, y)));
          of_emission = std::max(of_emission, Off(g.emission[k], frame.emission[k](x, y)));
        }
        const double of_motion =
            std::max(Off(g.motion.x, e.motion[0](x, y)), Off(g.motion.y, e.motion[1](x, y)));
        depth.wrong += Off(g.depth, e.depth(x, y)) > kTolerance ? 1 : 0;
        normal.wrong += of_normal > kTolerance ? 1 : 0;
        albedo.wrong += of_albedo > kTolerance ? 1 : 0;
        specular.wrong += of_specular > kTolerance ? 1 : 0;
        emission.wrong += of_emission > kTolerance ? 1 : 0;
        motion.wrong += of_motion > kTolerance ? 1 : 0;
        id.wrong += g.id != e.id(x, y) ? 1 : 0;
        roughness.wrong += Off(g.roughness, e.roughness(x, y)) > kTolerance ? 1 : 0;
      }
    }
    EXPECT_GT(seen, kWidth * kHeight / 4);
    for (const Count& count : {depth, normal, albedo, specular, emission, motion, id, roughness}) {
      EXPECT_LE(count.wrong, kWidth * kHeight * kPerTenThousand / 10000) << count.what;
    }
  }
};

TEST_F(GpuGuidesTest, OfTheBuiltinScenesAreTheCpus) {
  for (const std::string& name : BuiltinSceneNames()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    ExpectTheCpus(*scene, 0, 0);
    ExpectTheCpus(*scene, 1.5, 1.4);
  }
}

Texture Noise(int width, int height, uint32_t seed) {
  Texture texture;
  texture.width = width;
  texture.height = height;
  for (int i = 0; i < 4 * width * height; ++i) {
    texture.texels.push_back(
        static_cast<uint8_t>(HashCombine(seed, static_cast<uint32_t>(i)) & 255u));
  }
  return texture;
}

Transform Pose(vec3 translation, vec4 rotation, vec3 scale) {
  Transform transform;
  transform.translation = translation;
  transform.rotation = rotation;
  transform.scale = scale;
  return transform;
}

// One of everything that guides depend on: textures of each kind, normal maps with tangents and
// without, cut-out and blended layers, glass of all kinds, mirrored and moving instances, a moving
// camera, emitters seen from both sides.
Scene EverythingScene() {
  SceneBuilder builder;
  builder.scene.textures = {Noise(64, 64, 1), Noise(16, 9, 2), Noise(7, 13, 3)};
  builder.scene.textures[2].wrap_u = Wrap::kMirror;
  const auto panel = [&](float x, float y) {
    return Quad(vec3(x, y, -6), vec3(1.6f, 0, 0.3f), vec3(0.1f, 1.6f, 0));
  };
  Material textured = Lambert(vec3(0.8f, 0.7f, 0.6f));
  textured.ior = 1.5f;
  textured.base_color_texture.texture = 0;
  textured.metallic = 1.0f;
  textured.metallic_roughness_texture.texture = 1;
  textured.normal_texture.texture = 2;
  textured.normal_scale = 0.5f;
  builder.Add(panel(-4, 0.5f), textured);
  Mesh with_tangents = panel(-2, 0.5f);
  with_tangents.tangents.assign(4, vec4(glm::normalize(vec3(1.6f, 0, 0.3f)), -1));
  builder.Add(with_tangents, textured, Pose(vec3(0), vec4(0, 0, 0, 1), vec3(1, 1, 1.2f)));
  Material cut = Lambert(vec3(0.9f, 0.2f, 0.2f));
  cut.base_color_texture.texture = 1;
  cut.alpha_mode = AlphaMode::kMask;
  builder.Add(panel(0, 0.5f), cut);
  Material blended = cut;
  blended.alpha_mode = AlphaMode::kBlend;
  for (int i = 0; i < 3; ++i) {
    builder.Add(panel(2, 0.5f), blended, At(vec3(0, 0, -0.5f * static_cast<float>(i))));
  }
  const float roughnesses[] = {0.0f, 0.5f, 0.3f, 0.0f};
  for (int i = 0; i < 4; ++i) {
    Material glass = Glass(1.3f + 0.1f * static_cast<float>(i), roughnesses[i]);
    glass.solid = i < 2;
    glass.base_color = vec4(0.9f, 0.8f, 0.3f, 1);
    builder.Add(FacetedSphere(vec3(0), 0.7f, 2), glass,
                At(vec3(-3 + 2 * static_cast<float>(i), -1.3f, -5)));
  }
  const int moving = builder.Add(
      FacetedSphere(vec3(0), 0.6f, 2), Metal(vec3(0.9f, 0.6f, 0.3f), 0.3f),
      Pose(vec3(0, -0.3f, -4), Rotation(glm::normalize(vec3(1, 2, 3)), 1), vec3(-1, 0.7f, 1)));
  builder.Move(builder.InstanceNode(moving), vec3(0.4f, 0.2f, -0.3f));
  Material light = Emitter(vec3(3, 2, 1));
  light.emissive_texture.texture = 1;
  builder.Add(panel(-4, -3), light);
  Mesh back = panel(2.4f, -3);
  std::swap(back.indices[1], back.indices[2]);
  std::swap(back.indices[4], back.indices[5]);
  builder.Add(back, light);
  light.double_sided = true;
  builder.Add(back, light, At(vec3(-1.8f, 0, 0)));
  builder.Add(Quad(vec3(-20, -20, -12), vec3(40, 0, 0), vec3(0, 28, 0)), Lambert(vec3(0.4f)));
  builder.Move(0, vec3(0.2f, -0.1f, 0.3f));
  return builder.scene;
}

TEST_F(GpuGuidesTest, OfEverythingAreTheCpus) {
  ExpectTheCpus(EverythingScene(), 0, 0);
  ExpectTheCpus(EverythingScene(), 0.7, 0.5);
}

TEST_F(GpuGuidesTest, TinyPicturesAndNothingInSight) {
  SceneBuilder builder;
  for (const auto& [width, height] : {std::pair{1, 1}, {9, 1}, {1, 17}}) {
    for (const GpuGuides& g : Find(builder.scene, {}, width, height)) {
      EXPECT_EQ(g.id, 0u);
      EXPECT_EQ(g.depth, std::numeric_limits<float>::infinity());
      EXPECT_EQ(g.background, 1.0f);
      EXPECT_EQ(g.normal, vec3(0.0f));
      EXPECT_EQ(g.motion, vec2(0.0f));
    }
  }
}

TEST_F(GpuGuidesTest, SaysWhichSizesAreWrong) {
  SceneBuilder builder;
  SceneState state(builder.scene);
  state.Update(0, 0);
  auto accel = GpuAccel::Create(device_.get(), state);
  ASSERT_TRUE(accel.ok());
  auto finder = GpuGuideFinder::Create(device_.get(), accel->get());
  ASSERT_TRUE(finder.ok());
  const CameraView view = MakeCameraView(builder.scene.cameras[0], state.nodes()[0], 8, 4);
  CameraView other = view;
  std::vector<GpuGuides> guides(31);
  EXPECT_THAT(Run(accel->get(), finder->get(), view, view, &guides).message(),
              HasSubstr("of 8x4 pixels: the buffer has 2480 bytes, expected 2560"));
  other.width = 7;
  EXPECT_THAT(Run(accel->get(), finder->get(), view, other, &guides).message(),
              HasSubstr("the picture has 8x4 pixels and the last one 7x4"));
}

}  // namespace
}  // namespace stillray::render
