// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "trace_device.h"

#ifdef STILLRAY_WITH_VULKAN
#include "denoise/vulkan/host_denoiser.h"
#include "render/vulkan/vulkan_renderer.h"
#endif

namespace stillray {

Result<std::unique_ptr<Renderer>> CreateRendererOn(const Device& device, const Scene& scene,
                                                   const RenderSettings& settings) {
#ifdef STILLRAY_WITH_VULKAN
  const auto backend = std::dynamic_pointer_cast<vulkan::VulkanBackend>(BackendOf(device));
  if (backend != nullptr) {
    return render::CreateVulkanRenderer(scene, settings, backend->device());
  }
#else
  static_cast<void>(device);  // there is none but the CPU
#endif
  return Renderer::Create(scene, settings);
}

std::vector<LoggedStage> TraceStages(const RenderTimings& timings) {
  return {{"trace_guides", timings.primary_ms},
          {"trace_shading", timings.shade_ms},
          {"trace_shadow_rays", timings.shadow_ms},
          {"trace_bounce_rays", timings.bounce_ms},
          {"trace_copy", timings.copy_ms}};
}

}  // namespace stillray
