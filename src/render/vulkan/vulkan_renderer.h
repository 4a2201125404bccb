// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer on a Vulkan device: the same frames as on the CPU, up to rounding.
#pragma once

#include <memory>
#include <optional>

#include "gpu/device.h"
#include "render/vulkan/tracing_way.h"
#include "stillray/render.h"

namespace stillray::render {

struct VulkanRenderOptions {
  FirstHits first_hits = FirstHits::kAuto;  ///< drawn (Visibility) or traced
  TracingWay way = TracingWay::kAuto;       ///< for all other rays
  /// With kSampled, and kAuto on a GPU, textures differ from the CPU's by fractions of a texel.
  TextureWay textures = TextureWay::kExact;
  /// Approximate duration of a submission in milliseconds: other users of the device wait that
  /// long.
  double submission_ms = 200;
  /// As PictureTracerOptions.
  uint32_t most_pixels = 0;
};

/// As Renderer::Create. The same device and driver give the same bits. RenderTimings hold the
/// device's times.
/// \return also kUnsupported: the device lacks a feature, or an array of the scene is larger than
///     its storage buffers
Result<std::unique_ptr<Renderer>> CreateVulkanRenderer(const Scene& scene,
                                                       const RenderSettings& settings,
                                                       std::shared_ptr<gpu::Device> device,
                                                       const VulkanRenderOptions& options = {});

}  // namespace stillray::render
