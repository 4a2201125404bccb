// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Sampler, lights and steps of paths give the same on the device as on the CPU.
#include <gmock/gmock.h>

#include "core/random.h"
#include "gpu/vulkan_test.h"
#include "render/test_scenes.h"
#include "render/vulkan/gpu_lights.h"
#include "render_gpu/formulas_shared.h"
#include "render_gpu/gpu_batch.h"
#include "render_gpu/run_shader.h"

namespace stillray::render {
namespace shaders {
extern const std::uint32_t kFormulas[];
extern const std::size_t kFormulasWords;
}  // namespace shaders

namespace {

constexpr uint32_t kCount = 4096;

class GpuFormulasTest : public test::VulkanTest {
 protected:
  std::vector<FormulaValues> Compute(const GpuLights& lights,
                                     const std::vector<FormulaPlace>& places) {
    return RunShader<FormulaValues>(
        device_.get(),
        {.name = "formulas",
         .code = {shaders::kFormulas, shaders::kFormulasWords},
         .own_set = 0,
         .other_shape = GpuLights::kShape,
         .other_set = lights.set()},
        places, [&](VkCommandBuffer commands) { lights.RecordUpdate(commands); });
  }

  // Of the scene's lights a second later than those that the device was first given.
  void ExpectTheSame(const Scene& scene) {
    SceneState state(scene);
    state.Update(0, 0);
    LightSet lights(state);
    lights.Update(true);
    Result<std::unique_ptr<GpuLights>> on_device =
        GpuLights::Create(device_.get(), lights, scene.environment);
    ASSERT_TRUE(on_device.ok()) << on_device.status().message();
    lights.Update(state.Update(1, 0));
    ASSERT_TRUE((*on_device)->Update().ok());
    std::vector<FormulaPlace> places;
    for (uint32_t i = 0; i < kCount; ++i) {
      const vec3 in_box(UniformFloat(HashCombine(i, 1)), UniformFloat(HashCombine(i, 2)),
                        UniformFloat(HashCombine(i, 3)));
      places.push_back({in_box * 5.0f - vec3(2.5f, 1, 3), HashU32(i), RandomDirection(i), i});
    }
    const std::vector<FormulaValues> found = Compute(**on_device, places);
    int of_areas = 0;
    int of_points = 0;
    int differ = 0;
    const auto near = [](vec3 a, vec3 b, float tolerance) {
      return length(a - b) <= tolerance * std::max(1.0f, length(b));
    };
    for (uint32_t i = 0; i < kCount; ++i) {
      const FormulaValues e = ComputeFormulas(lights.arrays(), places[i]);
      const FormulaValues& f = found[i];
      ASSERT_EQ(f.sobol, e.sobol) << i;
      ASSERT_TRUE(near(vec3(f.halton), vec3(e.halton), 1e-6f)) << i;
      ASSERT_EQ(f.pixel_seed, e.pixel_seed) << i;
      ASSERT_EQ(f.offset, e.offset) << i;
      ASSERT_TRUE(near(f.frame_x, e.frame_x, 1e-6f)) << i;
      ASSERT_NEAR(f.frame_cosine, e.frame_cosine, 1e-6f) << i;
      // Where a sum of importances selects a light, or the sun ends between two texels, rounding
      // may decide differently.
      const bool same =
          near(f.direction, e.direction, 2e-5f) && near(vec3(f.density), vec3(e.density), 1e-2f) &&
          near(f.radiance, e.radiance, 1e-2f) && near(vec3(f.distance), vec3(e.distance), 1e-4f) &&
          near(f.environment, e.environment, 1e-2f) &&
          near(vec3(f.environment_density), vec3(e.environment_density), 1e-2f) &&
          near(vec3(f.total), vec3(e.total), 1e-4f) &&
          near(vec3(f.area_density), vec3(e.area_density), 1e-2f) && f.may_be_met == e.may_be_met &&
          near(vec3(f.survival), vec3(e.survival), 1e-4f) &&
          near(f.flight_weight, e.flight_weight, 1e-3f) &&
          near(vec3(f.flight_distance), vec3(e.flight_distance), 1e-3f) &&
          near(f.scattered, e.scattered, 1e-4f) && near(vec3(f.albedo), vec3(e.albedo), 1e-4f);
      differ += same ? 0 : 1;
      of_areas += e.area_density > 0 ? 1 : 0;
      of_points += e.area_density == 0 && e.density > 0 ? 1 : 0;
    }
    EXPECT_LE(differ, static_cast<int>(kCount / 500));
    EXPECT_GT(of_areas + of_points, static_cast<int>(kCount / 4));
  }
};

TEST_F(GpuFormulasTest, OfTheBuiltinScenesAreTheCpus) {
  for (const std::string& name : BuiltinSceneNames()) {
    SCOPED_TRACE(name);
    const Result<Scene> scene = MakeBuiltinScene(name);
    ASSERT_TRUE(scene.ok());
    ExpectTheSame(*scene);
  }
}

TEST_F(GpuFormulasTest, OfEveryKindOfLightAreTheCpus) {
  SceneBuilder builder;
  for (const LightType type : {LightType::kPoint, LightType::kSpot, LightType::kDirectional,
                               LightType::kDirectional, LightType::kPoint}) {
    PunctualLight light;
    light.type = type;
    light.intensity = vec3(2, 1, static_cast<float>(builder.scene.lights.size()));
    light.range = 6;
    light.inner_cone_angle = 0.3f;
    light.outer_cone_angle = 1.2f;
    Transform pose = At(vec3(0, 2, static_cast<float>(builder.scene.lights.size())));
    pose.rotation = Rotation(vec3(1, 0, 0), 1.0f + static_cast<float>(builder.scene.lights.size()));
    light.node = builder.AddNode(pose);
    builder.Move(light.node, vec3(1, 0, 0));
    builder.scene.lights.push_back(light);
  }
  Material both = Emitter(vec3(3));
  both.double_sided = true;
  builder.Add(FacetedSphere(vec3(0, 1, -1), 0.5f, 2), Emitter(vec3(1, 2, 3)));
  const int moving = builder.Add(Quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 0, -2)), both);
  builder.Move(builder.InstanceNode(moving), vec3(0, 0.5f, 0));
  ExpectTheSame(builder.scene);
  builder.scene.environment.radiance = vec3(0.5f);
  ExpectTheSame(builder.scene);
}

TEST_F(GpuFormulasTest, WithoutLightThereIsNone) {
  SceneBuilder builder;
  SceneState state(builder.scene);
  state.Update(0, 0);
  LightSet lights(state);
  lights.Update(true);
  Result<std::unique_ptr<GpuLights>> on_device =
      GpuLights::Create(device_.get(), lights, builder.scene.environment);
  ASSERT_TRUE(on_device.ok());
  const std::vector<FormulaPlace> places = {{vec3(0), 1, vec3(0, 0, 1), 2}};
  const std::vector<FormulaValues> found = Compute(**on_device, places);
  EXPECT_EQ(found[0].density, 0.0f);
  EXPECT_EQ(found[0].total, 0.0f);
  EXPECT_EQ(found[0].environment, vec3(0.0f));
  EXPECT_EQ(found[0].may_be_met, 0.0f);
}

}  // namespace
}  // namespace stillray::render
