// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The shaders that trace rays, as hardware ray tracing pipelines.
#pragma once

#include <memory>
#include <span>

#include "gpu/ray_pipeline.h"

namespace stillray::render {

enum class HardwareShader : uint8_t {
  kFirstHits,      ///< of batches of rays (GpuAccel)
  kTransmittance,  ///< the same
  kFindGuides,     ///< of the tracer, like all that follow
  kFindImages,
  kTraceShadows,
  kTraceNext,
};

/// \param sets  of the shader, with HardwareScene::kShape as the last one
/// \param constants  GpuAccel::constants
Result<std::unique_ptr<gpu::RayPipeline>> MakeHardwarePipeline(
    gpu::Device* device, HardwareShader shader, std::span<const VkDescriptorSetLayout> sets,
    uint32_t push_bytes, std::span<const uint32_t> constants);

}  // namespace stillray::render
