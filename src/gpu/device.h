// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A device to work with: one that stillray made, or a caller's own.
#pragma once

#include <memory>

#include "gpu/instance.h"
#include "gpu/turns.h"

namespace stillray::gpu {

/// A logical device and what is known of it. Owns nothing; a caller's device looks the same.
struct DeviceContext {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  DeviceFunctions vk;
  VkPhysicalDeviceMemoryProperties memory = {};
  VkPhysicalDeviceLimits limits = {};
  /// Offered only by devices of stillray's own, which are made for it.
  RayTracing ray_tracing;
  MemorySharing sharing;
  /// All stages that stillray's shaders run in.
  VkPipelineStageFlags shader_stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
};

/// \return kUnsupported if the device lacks what CheckDevice asks for, or a function
Result<DeviceContext> MakeContext(PFN_vkGetInstanceProcAddr get, VkInstance instance,
                                  VkPhysicalDevice physical, VkDevice device);

/// Makes what was written by the stages `from` visible to the stages `to`.
void MemoryBarrier(const DeviceContext& context, VkCommandBuffer commands,
                   VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
                   VkAccessFlags used);

/// A device of stillray's own with one queue, and a command buffer that runs and is waited for.
class Device {
 public:
  static Result<std::shared_ptr<Device>> Create(std::shared_ptr<Instance> instance,
                                                const DeviceInfo& info);
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device();

  const DeviceContext& context() const { return context_; }
  const DeviceInfo& info() const { return info_; }
  const std::shared_ptr<Instance>& instance() const { return instance_; }
  uint32_t queue_family() const { return queue_family_; }
  bool has_timestamps() const { return timestamp_bits_ != 0; }
  bool can_draw() const { return can_draw_; }

  /// The command buffer and the queue are one thread's at a time: to be held from Begin to Run.
  /// Threads have their turn in the order in which they asked.
  [[nodiscard]] Turn Lock() { return Turn(turns_); }
  /// Begins the command buffer anew. One at a time: Run before the next Begin.
  Result<VkCommandBuffer> Begin();
  /// Ends the command buffer, runs it and waits for it.
  Status Run();

 private:
  Device() = default;
  Status FindQueue();
  Status AddRayTracing();
  Status AddSharing();
  Status MakeCommandBuffer();

  Turns turns_;
  std::shared_ptr<Instance> instance_;
  DeviceInfo info_;
  DeviceContext context_;
  uint32_t queue_family_ = 0;
  uint32_t timestamp_bits_ = 0;
  bool can_draw_ = false;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

}  // namespace stillray::gpu
