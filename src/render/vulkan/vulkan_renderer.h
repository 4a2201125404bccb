// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer on a Vulkan device: the same frames as the one on the CPU, but for roundings.
#pragma once

#include <memory>
#include <optional>

#include "gpu/device.h"
#include "render/vulkan/tracing_way.h"
#include "stillray/render.h"

namespace stillray::render {

struct VulkanRenderOptions {
  std::optional<bool> add_by_group = {};  ///< GpuTracer::Create; without: what suits the device
  /// The camera's first hits are drawn (Visibility) rather than traced, where the device draws.
  bool rasterise = true;
  TracingWay way = TracingWay::kAuto;  ///< in which all other rays are traced
  /// Milliseconds that a submission may take, roughly: the device's other users wait for as long.
  double submission_ms = 200;
};

/// As Renderer::Create. The same device and driver give the same bits. RenderTimings hold the
/// device's own times.
/// \return also kUnsupported: the device lacks something, or an array of the scene is larger than
///         its storage buffers
Result<std::unique_ptr<Renderer>> CreateVulkanRenderer(const Scene& scene,
                                                       const RenderSettings& settings,
                                                       std::shared_ptr<gpu::Device> device,
                                                       const VulkanRenderOptions& options = {});

}  // namespace stillray::render
