// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/memory_budget.h"

#include <array>

#include "gpu/extensions.h"

namespace stillray::gpu {
namespace {

constexpr std::array kBudgetExtensions = {VK_EXT_MEMORY_BUDGET_EXTENSION_NAME};

uint32_t LargestHeap(const VkPhysicalDeviceMemoryProperties& memory) {
  uint32_t largest = 0;
  const auto own = [&](uint32_t i) {
    return (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0;
  };
  for (uint32_t i = 1; i < memory.memoryHeapCount; ++i) {
    if (own(i) &&
        (!own(largest) || memory.memoryHeaps[i].size > memory.memoryHeaps[largest].size)) {
      largest = i;
    }
  }
  return largest;
}

}  // namespace

uint64_t FreeMemory(const Device& device) {
  const Instance& instance = *device.instance();
  const VkPhysicalDeviceMemoryProperties& memory = device.context().memory;
  const uint32_t heap = LargestHeap(memory);
  // Core function of Vulkan 1.1. Extensions for physical device queries need not be enabled.
  const auto query = reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties2>(
      instance.get_instance_proc_addr()(instance.handle(), "vkGetPhysicalDeviceMemoryProperties2"));
  if (query != nullptr &&
      HasExtensions(instance.functions(), device.info().handle, kBudgetExtensions)) {
    VkPhysicalDeviceMemoryBudgetPropertiesEXT budget = {};
    budget.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT;
    VkPhysicalDeviceMemoryProperties2 properties = {};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2;
    properties.pNext = &budget;
    query(device.info().handle, &properties);
    const uint64_t most = budget.heapBudget[heap];
    const uint64_t used = budget.heapUsage[heap];
    return most > used ? most - used : 0;
  }
  return memory.memoryHeaps[heap].size / 2;
}

}  // namespace stillray::gpu
