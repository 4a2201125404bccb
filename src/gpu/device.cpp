// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/device.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "gpu/pipeline_statistics.h"
#include "gpu/shared_pipelines.h"

namespace stillray::gpu {

Result<DeviceContext> MakeContext(PFN_vkGetInstanceProcAddr get, VkInstance instance,
                                  VkPhysicalDevice physical, VkDevice device) {
  const Result<InstanceFunctions> of_instance = LoadInstanceFunctions(get, instance);
  if (!of_instance.ok()) {
    return of_instance.status();
  }
  STILLRAY_RETURN_IF_ERROR(CheckDevice(*of_instance, physical));
  const Result<DeviceFunctions> of_device =
      LoadDeviceFunctions(of_instance->GetDeviceProcAddr, device);
  if (!of_device.ok()) {
    return of_device.status();
  }
  DeviceContext context;
  context.physical = physical;
  context.device = device;
  context.vk = *of_device;
  of_instance->GetPhysicalDeviceMemoryProperties(physical, &context.memory);
  VkPhysicalDeviceProperties properties = {};
  of_instance->GetPhysicalDeviceProperties(physical, &properties);
  context.limits = properties.limits;
  context.is_software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  return context;
}

Device::Device() = default;

/// Selects a compute queue family, preferably with graphics and timestamps.
Status Device::FindQueue() {
  const InstanceFunctions& vk = instance_->functions();
  uint32_t count = 0;
  vk.GetPhysicalDeviceQueueFamilyProperties(info_.handle, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.GetPhysicalDeviceQueueFamilyProperties(info_.handle, &count, families.data());
  int best = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if ((families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) {
      continue;
    }
    const bool draws = (families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0;
    const int merit = 1 + (draws ? 1 : 0) + (families[i].timestampValidBits != 0 ? 2 : 0);
    if (merit > best) {
      best = merit;
      queue_family_ = i;
      timestamp_bits_ = families[i].timestampValidBits;
      can_draw_ = draws;
    }
  }
  return best > 0 ? Status::Ok()
                  : Status::Unsupported(
                        fmt::format("{}: the device has no queue for compute", info_.name));
}

/// Adds the ray tracing functions and limits to the context, for devices with the extensions.
Status Device::AddRayTracing() {
  context_.ray_tracing = info_.ray_tracing;
  context_.shader_stages |= VK_PIPELINE_STAGE_RAY_TRACING_SHADER_BIT_KHR;
  return LoadRayTracingFunctions(instance_->functions().GetDeviceProcAddr, context_.device,
                                 &context_.vk);
}

Status Device::AddSharing() {
  context_.sharing = info_.sharing;
  return LoadSharingFunctions(instance_->functions().GetDeviceProcAddr, context_.device,
                              &context_.vk);
}

Status Device::MakeCommandBuffer() {
  const DeviceFunctions& vk = context_.vk;
  VkCommandPoolCreateInfo pool = {};
  pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  pool.queueFamilyIndex = queue_family_;
  STILLRAY_RETURN_IF_ERROR(ToStatus(vk.CreateCommandPool(context_.device, &pool, nullptr, &pool_),
                                    "creating a command pool"));
  VkCommandBufferAllocateInfo buffer = {};
  buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  buffer.commandPool = pool_;
  buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  buffer.commandBufferCount = 1;
  STILLRAY_RETURN_IF_ERROR(ToStatus(vk.AllocateCommandBuffers(context_.device, &buffer, &commands_),
                                    "creating a command buffer"));
  VkFenceCreateInfo fence = {};
  fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
  return ToStatus(vk.CreateFence(context_.device, &fence, nullptr, &fence_), "creating a fence");
}

void MemoryBarrier(const DeviceContext& context, VkCommandBuffer commands,
                   VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
                   VkAccessFlags used) {
  VkMemoryBarrier barrier = {};
  barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  barrier.srcAccessMask = written;
  barrier.dstAccessMask = used;
  context.vk.CmdPipelineBarrier(commands, from, to, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

Result<std::shared_ptr<Device>> Device::Create(std::shared_ptr<Instance> instance,
                                               const DeviceInfo& info) {
  STILLRAY_RETURN_IF_ERROR(info.usable);
  std::shared_ptr<Device> made(new Device());
  made->instance_ = std::move(instance);
  made->info_ = info;
  STILLRAY_RETURN_IF_ERROR(made->FindQueue());
  const float priority = 1;
  VkDeviceQueueCreateInfo queue = {};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueFamilyIndex = made->queue_family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceFeatures features = {};
  features.shaderStorageImageExtendedFormats = VK_TRUE;
  RayTracingFeatures ray_tracing(info.ray_tracing);
  VkDeviceCreateInfo create = {};
  create.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  create.pEnabledFeatures = &features;
  std::vector<const char*> extensions;
  const bool statistics = WantsPipelineStatistics(made->instance_->functions(), info.handle);
  VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR of_statistics = StatisticsFeature();
  if (info.ray_tracing.offered) {
    create.pNext = ray_tracing.chain();
    extensions.insert(extensions.end(), kRayTracingExtensions.begin(), kRayTracingExtensions.end());
  }
  if (info.sharing.offered) {
    extensions.insert(extensions.end(), kSharingExtensions.begin(), kSharingExtensions.end());
  }
  if (statistics) {
    of_statistics.pNext = const_cast<void*>(create.pNext);
    create.pNext = &of_statistics;
    extensions.insert(extensions.end(), kStatisticsExtensions.begin(), kStatisticsExtensions.end());
  }
  create.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  create.ppEnabledExtensionNames = extensions.data();
  VkDevice device = VK_NULL_HANDLE;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(made->instance_->functions().CreateDevice(info.handle, &create, nullptr, &device),
               "creating a device"));
  Result<DeviceContext> context = MakeContext(made->instance_->get_instance_proc_addr(),
                                              made->instance_->handle(), info.handle, device);
  if (!context.ok()) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDevice>(
        made->instance_->functions().GetDeviceProcAddr(device, "vkDestroyDevice"));
    if (destroy != nullptr) {
      destroy(device, nullptr);
    }
    return context.status();
  }
  made->context_ = std::move(context.value());
  made->context_.timestamp_bits = made->timestamp_bits_;
  VkPhysicalDeviceProperties properties = {};
  made->instance_->functions().GetPhysicalDeviceProperties(info.handle, &properties);
  made->pipeline_cache_.Create(made->context_, properties);
  made->context_.pipeline_cache = made->pipeline_cache_.handle();
  made->pipelines_ = std::make_unique<SharedPipelines>(&made->context_);
  made->context_.pipelines = made->pipelines_.get();
  if (info.ray_tracing.offered) {
    STILLRAY_RETURN_IF_ERROR(made->AddRayTracing());
  }
  if (info.sharing.offered) {
    STILLRAY_RETURN_IF_ERROR(made->AddSharing());
  }
  if (statistics) {
    STILLRAY_RETURN_IF_ERROR(LoadStatisticsFunctions(made->instance_->functions().GetDeviceProcAddr,
                                                     device, &made->context_.vk));
  }
  made->context_.vk.GetDeviceQueue(device, made->queue_family_, 0, &made->queue_);
  STILLRAY_RETURN_IF_ERROR(made->MakeCommandBuffer());
  return made;
}

Device::~Device() {
  if (context_.device == VK_NULL_HANDLE) {
    return;
  }
  if (hangs_) {
    // Resources of a hanging device, and its instance, can neither be waited for nor destroyed.
    using Kept = std::pair<std::shared_ptr<Instance>, std::unique_ptr<SharedPipelines>>;
    static auto* const kept = new std::vector<Kept>();
    kept->emplace_back(instance_, std::move(pipelines_));
    return;
  }
  const DeviceFunctions& vk = context_.vk;
  vk.DeviceWaitIdle(context_.device);
  pipelines_.reset();
  pipeline_cache_.SaveAndDestroy(context_);
  vk.DestroyFence(context_.device, fence_, nullptr);
  vk.DestroyCommandPool(context_.device, pool_, nullptr);
  vk.DestroyDevice(context_.device, nullptr);
}

namespace {

/// Timeout for a GPU: STILLRAY_GPU_TIMEOUT, or 10 seconds if it is not a positive integer.
uint64_t WaitSeconds() {
  constexpr uint64_t kDefault = 10;
  constexpr uint64_t kMost = 1'000'000;
  const char* given = std::getenv("STILLRAY_GPU_TIMEOUT");
  const std::string_view text = given != nullptr ? given : "";
  uint64_t seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && seconds > 0 ? std::min(seconds, kMost) : kDefault;
}

Status HangsError() {
  return Status::Unsupported(fmt::format(
      "Vulkan: waiting for the device: it hangs; its work was not finished after {} s, expected "
      "fractions of a second (STILLRAY_GPU_TIMEOUT=N waits N s)",
      WaitSeconds()));
}

}  // namespace

Result<VkCommandBuffer> Device::Begin() {
  if (hangs_) {
    return HangsError();
  }
  const DeviceFunctions& vk = context_.vk;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(vk.ResetCommandPool(context_.device, pool_, 0), "resetting the command pool"));
  VkCommandBufferBeginInfo begin = {};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(vk.BeginCommandBuffer(commands_, &begin), "beginning a command buffer"));
  return commands_;
}

Status Device::Submit() {
  const DeviceFunctions& vk = context_.vk;
  VkSubmitInfo submit = {};
  submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  STILLRAY_RETURN_IF_ERROR(ToStatus(vk.QueueSubmit(queue_, 1, &submit, fence_), "submitting work"));
  // No timeout for software drivers.
  const uint64_t limit = info_.is_gpu ? WaitSeconds() * 1'000'000'000 : UINT64_MAX;
  const VkResult waited = vk.WaitForFences(context_.device, 1, &fence_, VK_TRUE, limit);
  if (waited == VK_TIMEOUT) {
    hangs_ = true;
    return HangsError();
  }
  return ToStatus(waited, "waiting for the device");
}

Status Device::Run() {
  const DeviceFunctions& vk = context_.vk;
  STILLRAY_RETURN_IF_ERROR(ToStatus(vk.EndCommandBuffer(commands_), "ending a command buffer"));
  const Status done = Submit();
  if (!done.ok()) {
    if (!hangs_) {
      vk.DeviceWaitIdle(context_.device);  // the caller may destroy resources of the submission
    }
    return done;
  }
  return ToStatus(vk.ResetFences(context_.device, 1, &fence_), "resetting a fence");
}

}  // namespace stillray::gpu
