// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The shaders that trace rays, as Vulkan ray tracing pipelines.
#pragma once

#include <memory>
#include <span>

#include "gpu/ray_pipeline.h"

namespace stillray::render {

enum class HardwareShader : uint8_t {
  kFirstHits,      ///< first hits of a batch of rays (GpuAccel)
  kTransmittance,  ///< transmittance of a batch of rays (GpuAccel)
  kFindGuides,     ///< this and all later shaders belong to GpuTracer
  kFindImages,
  kTraceShadows,
  kTraceNext,
};

/// \param sets  layouts of the shader's descriptor sets, with that of HardwareScene::kShape last
/// \param constants  GpuAccel::constants
Result<std::unique_ptr<gpu::RayPipeline>> MakeHardwarePipeline(
    gpu::Device* device, HardwareShader shader, std::span<const VkDescriptorSetLayout> sets,
    uint32_t push_bytes, std::span<const uint32_t> constants);

}  // namespace stillray::render
