// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Converts the plan of a frame to the shaders' parameters.
#pragma once

#include "denoise/plan.h"
#include "denoise/vulkan/frame_images.h"
#include "denoise/vulkan/frame_shared.h"

namespace stillray::vulkan {

/// The set of images for these settings.
Shape ShapeOf(const Settings& settings, int width, int height, int signals, Storage storage);

FrameParameters MakeParameters(const FramePlan& plan, const FrameFacts& facts, const Shape& shape);

}  // namespace stillray::vulkan
