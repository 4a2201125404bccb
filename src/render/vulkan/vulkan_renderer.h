// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer on a Vulkan device: the same frames as the one on the CPU, but for roundings.
#pragma once

#include <memory>
#include <optional>

#include "gpu/device.h"
#include "stillray/render.h"

namespace stillray::render {

/// As Renderer::Create. The same device and driver give the same bits. RenderTimings hold the
/// device's own times.
/// \param add_by_group  GpuTracer::Create; without: what suits the device
/// \return also kUnsupported: the device lacks something, or an array of the scene is larger than
///         its storage buffers
Result<std::unique_ptr<Renderer>> CreateVulkanRenderer(const Scene& scene,
                                                       const RenderSettings& settings,
                                                       std::shared_ptr<gpu::Device> device,
                                                       std::optional<bool> add_by_group = {});

}  // namespace stillray::render
