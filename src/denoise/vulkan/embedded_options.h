// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the options of a denoiser in a renderer's own frame (stillray/vulkan.hpp) mean for its
/// filters.
#pragma once

#include "denoise/guide_source.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "denoise/vulkan/layer_passes.h"
#include "stillray/vulkan.hpp"

namespace stillray::vulkan {

PipelineOptions PipelineOptionsOf(const VulkanOptions& options);

// Of a layer with virtual guides.
PipelineOptions LayerOptionsOf(const VulkanOptions& options, GuideSource source);
LayerShape LayerShapeOf(const VulkanOptions& options, GuideSource source);

}  // namespace stillray::vulkan
