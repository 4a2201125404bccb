// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The driver's statistics of compiled shaders (registers, spilled bytes, occupancy), for tuning:
/// VK_KHR_pipeline_executable_properties. If STILLRAY_PIPELINE_STATISTICS is set to a value other
/// than 0, the statistics of each pipeline are printed to standard error on creation.
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

/// Whether the environment variable is set and the device supports the extension.
bool WantsPipelineStatistics(const InstanceFunctions& functions, VkPhysicalDevice device);

/// The feature to enable on the device.
VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR StatisticsFeature();

/// Flags of Vk...PipelineCreateInfo; 0 without statistics.
VkPipelineCreateFlags StatisticsFlags(const DeviceContext& context);

/// Prints the statistics of a pipeline created with StatisticsFlags; no output if the flags are 0.
/// \param constants  specialisation constants, which are printed with the name
void PrintStatistics(const DeviceContext& context, const char* name,
                     std::span<const uint32_t> constants, VkPipeline pipeline);

}  // namespace stillray::gpu
