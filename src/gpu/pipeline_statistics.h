// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the driver reports of compiled shaders (registers, spilled bytes, occupancy), for tuning:
/// VK_KHR_pipeline_executable_properties. Off unless STILLRAY_PIPELINE_STATISTICS is set to
/// anything but 0; then each pipeline prints its statistics to standard error when it is created.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gpu/functions.h"

namespace stillray::gpu {

struct DeviceContext;

inline constexpr const char* kPipelineStatisticsVariable = "STILLRAY_PIPELINE_STATISTICS";

/// Extensions to enable on a device for statistics, beside Vulkan 1.1.
inline constexpr std::array kStatisticsExtensions = {
    VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME};

/// The variable is set, and the device offers the extension.
bool WantsPipelineStatistics(const InstanceFunctions& functions, VkPhysicalDevice device);

/// The feature to create the device with.
VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR StatisticsFeature();

/// For VkComputePipelineCreateInfo and the like; 0 without statistics.
VkPipelineCreateFlags StatisticsFlags(const DeviceContext& context);

/// Prints the statistics of a pipeline that was created with StatisticsFlags; nothing without.
/// \param constants  specialisation constants, which are printed with the name
void PrintStatistics(const DeviceContext& context, const char* name,
                     std::span<const uint32_t> constants, VkPipeline pipeline);

}  // namespace stillray::gpu
