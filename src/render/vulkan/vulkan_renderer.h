// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer on a Vulkan device: its frames equal those of the CPU up to rounding.
#pragma once

#include <memory>
#include <optional>

#include "gpu/device.h"
#include "render/vulkan/tracing_way.h"
#include "stillray/render.h"

namespace stillray::render {

struct VulkanRenderOptions {
  FirstHits first_hits = FirstHits::kAuto;  ///< primary hits: rasterised (Visibility) or traced
  TracingWay way = TracingWay::kAuto;       ///< tracing of all other rays
  /// With kSampled, and kAuto on a GPU, textures differ from the CPU's by fractions of a texel.
  TextureWay textures = TextureWay::kExact;
  /// Approximate duration of a submission in milliseconds: other users of the device wait for its
  /// duration.
  double submission_ms = 200;
  /// See PictureTracerOptions.
  uint32_t most_pixels = 0;
};

/// Renderer::Create for a Vulkan device. Frames are bit-identical on a given device and driver.
/// RenderTimings are measured on the device.
/// \return also kUnsupported: the device lacks a feature, or an array of the scene is larger than
///     its storage buffers
Result<std::unique_ptr<Renderer>> CreateVulkanRenderer(const Scene& scene,
                                                       const RenderSettings& settings,
                                                       std::shared_ptr<gpu::Device> device,
                                                       const VulkanRenderOptions& options = {});

}  // namespace stillray::render
