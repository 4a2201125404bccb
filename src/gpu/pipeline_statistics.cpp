// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/pipeline_statistics.h"

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "gpu/device.h"
#include "gpu/extensions.h"

namespace stillray::gpu {
namespace {

std::string ValueOf(const VkPipelineExecutableStatisticKHR& s) {
  switch (s.format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR:
      return s.value.b32 != 0 ? "yes" : "no";
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR:
      return fmt::format("{}", s.value.i64);
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR:
      return fmt::format("{}", s.value.u64);
    default:
      return fmt::format("{:.4g}", s.value.f64);
  }
}

std::vector<VkPipelineExecutablePropertiesKHR> ExecutablesOf(const DeviceContext& context,
                                                             VkPipeline pipeline) {
  VkPipelineInfoKHR info = {};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR;
  info.pipeline = pipeline;
  uint32_t count = 0;
  context.vk.GetPipelineExecutablePropertiesKHR(context.device, &info, &count, nullptr);
  VkPipelineExecutablePropertiesKHR empty = {};
  empty.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR;
  std::vector<VkPipelineExecutablePropertiesKHR> executables(count, empty);
  context.vk.GetPipelineExecutablePropertiesKHR(context.device, &info, &count, executables.data());
  executables.resize(count);
  return executables;
}

std::vector<VkPipelineExecutableStatisticKHR> StatisticsOf(const DeviceContext& context,
                                                           VkPipeline pipeline, uint32_t index) {
  VkPipelineExecutableInfoKHR info = {};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR;
  info.pipeline = pipeline;
  info.executableIndex = index;
  uint32_t count = 0;
  context.vk.GetPipelineExecutableStatisticsKHR(context.device, &info, &count, nullptr);
  VkPipelineExecutableStatisticKHR empty = {};
  empty.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
  std::vector<VkPipelineExecutableStatisticKHR> statistics(count, empty);
  context.vk.GetPipelineExecutableStatisticsKHR(context.device, &info, &count, statistics.data());
  statistics.resize(count);
  return statistics;
}

}  // namespace

bool WantsPipelineStatistics(const InstanceFunctions& functions, VkPhysicalDevice device) {
  const char* given = std::getenv(kPipelineStatisticsVariable);
  return given != nullptr && given[0] != '\0' && std::string_view(given) != "0" &&
         HasExtensions(functions, device, kStatisticsExtensions);
}

VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR StatisticsFeature() {
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR feature = {};
  feature.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR;
  feature.pipelineExecutableInfo = VK_TRUE;
  return feature;
}

VkPipelineCreateFlags StatisticsFlags(const DeviceContext& context) {
  return context.vk.GetPipelineExecutableStatisticsKHR != nullptr
             ? VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR
             : 0;
}

void PrintStatistics(const DeviceContext& context, const char* name,
                     std::span<const uint32_t> constants, VkPipeline pipeline) {
  if (context.vk.GetPipelineExecutableStatisticsKHR == nullptr || pipeline == VK_NULL_HANDLE) {
    return;
  }
  const std::vector<VkPipelineExecutablePropertiesKHR> executables =
      ExecutablesOf(context, pipeline);
  for (uint32_t i = 0; i < executables.size(); ++i) {
    std::string line =
        fmt::format("shader {} ({}), {}:", name, fmt::join(constants, " "), executables[i].name);
    for (const VkPipelineExecutableStatisticKHR& s : StatisticsOf(context, pipeline, i)) {
      line += fmt::format(" {} {};", s.name, ValueOf(s));
    }
    std::fprintf(stderr, "%s\n", line.c_str());
  }
}

}  // namespace stillray::gpu
