// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A Vulkan device: one created by stillray, or the caller's own.
#pragma once

#include <functional>
#include <memory>

#include "gpu/fair_mutex.h"
#include "gpu/instance.h"
#include "gpu/pipeline_cache.h"

namespace stillray::gpu {

class SharedPipelines;

/// Memory of a caller's allocator; see VulkanAllocator.
struct OwnedMemory {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  void* handle = nullptr;
};

/// A caller's allocator, for memory that is not mapped by the host.
struct MemorySource {
  std::function<VkResult(const VkMemoryRequirements&, OwnedMemory*)> allocate;
  std::function<void(const OwnedMemory&)> free;
};

/// A logical device with its properties and functions. Non-owning; also describes a caller's
/// device.
struct DeviceContext {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  DeviceFunctions vk;
  VkPhysicalDeviceMemoryProperties memory = {};
  VkPhysicalDeviceLimits limits = {};
  /// Available only on devices that stillray creates.
  RayTracing ray_tracing;
  MemorySharing sharing;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  SharedPipelines* pipelines = nullptr;  ///< owned by Device or a denoiser
  MemorySource memory_source;            ///< empty: vkAllocateMemory
  bool is_software = false;              ///< software driver that runs on the CPU
  /// Valid bits of the queue's timestamps; higher bits are undefined. 64 for a caller's device.
  uint32_t timestamp_bits = 64;
  /// All stages that execute stillray's shaders.
  VkPipelineStageFlags shader_stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
};

/// Creates the context of a device. The caller creates `pipelines` (shared_pipelines.h), and
/// destroys them before the device.
/// \return kUnsupported if the device fails CheckDevice or lacks a function
Result<DeviceContext> MakeContext(PFN_vkGetInstanceProcAddr get, VkInstance instance,
                                  VkPhysicalDevice physical, VkDevice device);

/// Records a barrier that makes writes of the stages `from` visible to the stages `to`.
void MemoryBarrier(const DeviceContext& context, VkCommandBuffer commands,
                   VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
                   VkAccessFlags used);

/// A device created by stillray, with one queue and one command buffer; submissions are
/// synchronous.
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
  const PipelineCache& pipeline_cache() const { return pipeline_cache_; }
  bool can_draw() const { return can_draw_; }

  /// Protects the command buffer and the queue; hold it from Begin to Run. Threads acquire it in
  /// FIFO order.
  [[nodiscard]] FairLock Lock() { return FairLock(mutex_); }
  /// Resets the command buffer and begins recording. Call Run before the next Begin.
  Result<VkCommandBuffer> Begin();
  /// Ends the command buffer, submits it and waits for its completion: on a GPU at most 10 seconds,
  /// or the number of seconds in the environment variable STILLRAY_GPU_TIMEOUT. A device without a
  /// display has no watchdog, and a shader that never terminates would block the program forever.
  /// After a timeout the device is lost: Run and Begin fail, and no Vulkan object is destroyed.
  Status Run();

 private:
  Device();
  Status FindQueue();
  Status AddRayTracing();
  Status AddSharing();
  Status MakeCommandBuffer();
  Status Submit();

  FairMutex mutex_;
  std::shared_ptr<Instance> instance_;
  DeviceInfo info_;
  DeviceContext context_;
  std::unique_ptr<SharedPipelines> pipelines_;
  uint32_t queue_family_ = 0;
  uint32_t timestamp_bits_ = 0;
  bool can_draw_ = false;
  bool hangs_ = false;
  PipelineCache pipeline_cache_;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
};

}  // namespace stillray::gpu
