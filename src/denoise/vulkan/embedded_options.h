// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Converts the options of a denoiser embedded in a renderer (stillray/vulkan.hpp) to those of its
/// filters.
#pragma once

#include "denoise/guide_source.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "denoise/vulkan/layer_passes.h"
#include "stillray/vulkan.hpp"

namespace stillray::vulkan {

PipelineOptions PipelineOptionsOf(const VulkanOptions& options);

// Options of a layer with virtual guides.
PipelineOptions LayerOptionsOf(const VulkanOptions& options, GuideSource source);
LayerShape LayerShapeOf(const VulkanOptions& options, GuideSource source);

}  // namespace stillray::vulkan
