// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/hardware_pipelines.h"

namespace stillray::render {
namespace shaders {
#define STILLRAY_SHADER(name)                   \
  extern const std::uint32_t kHardware##name[]; \
  extern const std::size_t kHardware##name##Words;
STILLRAY_SHADER(FirstHits)
STILLRAY_SHADER(Transmittance)
STILLRAY_SHADER(FindGuides)
STILLRAY_SHADER(FindImages)
STILLRAY_SHADER(TraceShadows)
STILLRAY_SHADER(TraceNext)
STILLRAY_SHADER(ClosestHit)
STILLRAY_SHADER(Miss)
STILLRAY_SHADER(ShadowMiss)
STILLRAY_SHADER(ShadowHit)
STILLRAY_SHADER(BatchShadowHit)
#undef STILLRAY_SHADER
}  // namespace shaders

namespace {

#define STILLRAY_CODE(name) \
  { shaders::kHardware##name, shaders::kHardware##name##Words }

/// Adds the hit and miss shaders of first-hit queries.
void AddFirstHit(gpu::RayPipelineInfo* info) {
  info->miss = STILLRAY_CODE(Miss);
  info->closest_hit = STILLRAY_CODE(ClosestHit);
}

gpu::RayPipelineInfo InfoOf(HardwareShader shader) {
  gpu::RayPipelineInfo info;
  switch (shader) {
    case HardwareShader::kFirstHits:
      info.name = "first_hits";
      info.generation = STILLRAY_CODE(FirstHits);
      AddFirstHit(&info);
      break;
    case HardwareShader::kTransmittance:
      info.name = "transmittance";
      info.generation = STILLRAY_CODE(Transmittance);
      info.miss = STILLRAY_CODE(ShadowMiss);
      info.any_hit = STILLRAY_CODE(BatchShadowHit);
      break;
    case HardwareShader::kFindGuides:
      info.name = "find_guides";
      info.generation = STILLRAY_CODE(FindGuides);
      AddFirstHit(&info);
      break;
    case HardwareShader::kFindImages:
      info.name = "find_images";
      info.generation = STILLRAY_CODE(FindImages);
      AddFirstHit(&info);
      break;
    case HardwareShader::kTraceShadows:
      info.name = "trace_shadows";
      info.generation = STILLRAY_CODE(TraceShadows);
      info.miss = STILLRAY_CODE(ShadowMiss);
      info.any_hit = STILLRAY_CODE(ShadowHit);
      break;
    case HardwareShader::kTraceNext:
      info.name = "trace_next";
      info.generation = STILLRAY_CODE(TraceNext);
      AddFirstHit(&info);
      break;
  }
  return info;
}

#undef STILLRAY_CODE

}  // namespace

Result<std::unique_ptr<gpu::RayPipeline>> MakeHardwarePipeline(
    gpu::Device* device, HardwareShader shader, std::span<const VkDescriptorSetLayout> sets,
    uint32_t push_bytes, std::span<const uint32_t> constants) {
  gpu::RayPipelineInfo info = InfoOf(shader);
  info.sets = sets;
  info.push_bytes = push_bytes;
  info.constants = constants;
  return gpu::RayPipeline::Create(device, info);
}

}  // namespace stillray::render
