// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Translates the commands of a dry device, which executes nothing, to those of a schedule.
#pragma once

#include <string>
#include <vector>

#include "denoise/shader_pack.h"
#include "gpu/dry_device.h"

namespace stillray::vulkan {

/// The name of a format without VK_FORMAT_; empty for VK_FORMAT_UNDEFINED.
std::string FormatName(VkFormat format);

/// Replaces the numbers of resources and shaders by names.
/// \param schedule  must contain the device's images and buffers, in the device's order
std::vector<ScheduleCommand> TranslateCommands(const std::vector<gpu::DryCommand>& commands,
                                               const gpu::DryDevice& dry,
                                               const FrameSchedule& schedule,
                                               const ShaderTable& table);

/// Sets `is_history` of the resources that a frame may read before writing, and that some frame
/// writes.
void MarkHistory(const ShaderTable& table, FrameSchedule* schedule);

}  // namespace stillray::vulkan
