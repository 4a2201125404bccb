// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Commands of a device that executes nothing, in the words of a schedule.
#pragma once

#include <string>
#include <vector>

#include "denoise/shader_pack.h"
#include "gpu/dry_device.h"

namespace stillray::vulkan {

/// Without VK_FORMAT_; empty for VK_FORMAT_UNDEFINED.
std::string FormatName(VkFormat format);

/// The same commands with names in place of numbers.
/// \param schedule  has the device's images and buffers, in their order there
std::vector<ScheduleCommand> TranslateCommands(const std::vector<gpu::DryCommand>& commands,
                                               const gpu::DryDevice& dry,
                                               const FrameSchedule& schedule,
                                               const ShaderTable& table);

/// Finds the resources that frames may read before they write them, and that some frame writes.
void MarkHistory(const ShaderTable& table, FrameSchedule* schedule);

}  // namespace stillray::vulkan
