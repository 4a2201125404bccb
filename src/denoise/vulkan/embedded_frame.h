// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A renderer's frame (stillray/vulkan.hpp): its properties and inputs, and checks of their
/// completeness.
#pragma once

#include <span>

#include "denoise/guide_source.h"
#include "denoise/plan.h"
#include "denoise/vulkan/frame_images.h"
#include "denoise/vulkan/layer_passes.h"
#include "stillray/vulkan.hpp"

namespace stillray::vulkan {

/// \param width, height  of the frame
FrameFacts FactsOf(const VulkanFrame& frame, int width, int height);
FrameInputs InputsOf(const VulkanFrame& frame);

/// \return kInvalidArgument naming the camera for which hit distances cannot be converted to guides
Result<VirtualInputs> VirtualInputsOf(const VulkanFrame& frame, GuideSource source, int width,
                                      int height);

/// Checks that all images that a layer needs are given.
Status CheckVirtualGuides(const VulkanFrame& frame, GuideSource source);

/// Checks that all images that the settings need are given. \param jittered  this frame or an
/// earlier one was jittered
Status CheckFrame(const VulkanFrame& frame, const Settings& settings, bool transmission,
                  bool fills_guides, bool jittered);

/// Checks the size, and the outputs of signals. \param most_width, most_height  of the images
/// \param layers  of the frame; signals of layers with virtual guides have no output
Status CheckOutputs(const VulkanFrame& frame, int most_width, int most_height,
                    std::span<const SignalGroup> groups, const LayerList& layers);

}  // namespace stillray::vulkan
