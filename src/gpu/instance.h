// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The Vulkan instance, and the physical devices of the system.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gpu/functions.h"
#include "gpu/ray_tracing.h"
#include "gpu/shared_memory.h"

namespace stillray::gpu {

/// A physical device of the system.
struct DeviceInfo {
  VkPhysicalDevice handle = VK_NULL_HANDLE;
  int index = 0;          ///< N of "vulkan:N": index in the loader's order
  std::string name;       ///< device name as reported by the driver
  std::string driver;     ///< driver name and version
  const char* kind = "";  ///< "discrete GPU", "integrated GPU", "virtual GPU", "software", "other"
  bool is_gpu = false;    ///< a hardware device: neither software nor unknown
  int rank = 0;           ///< order of preference: discrete, virtual, integrated, software
  uint32_t api_version = 0;   ///< encoded as VK_API_VERSION_*
  uint64_t memory_bytes = 0;  ///< size of the largest device-local heap
  Status usable;              ///< ok, or the missing feature
  RayTracing ray_tracing;     ///< support for ray tracing pipelines, and their limits
  MemorySharing sharing;      ///< support for memory that other APIs can import
};

/// Messages of the validation layer; any message fails the tests. Thread-safe.
class Messages {
 public:
  void Add(std::string text);
  std::vector<std::string> Take();

 private:
  std::mutex mutex_;
  std::vector<std::string> list_;
};

struct InstanceOptions {
  bool validation = false;       ///< core and synchronisation validation
  const char* loader = nullptr;  ///< file name of the Vulkan loader; nullptr: the default
};

/// A Vulkan 1.1 instance. Not copied or moved; share it by pointer.
class Instance {
 public:
  /// \return kUnsupported: no loader, no driver, or no validation layer although requested
  static Result<std::shared_ptr<Instance>> Create(const InstanceOptions& options = {});
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;
  ~Instance();

  /// All devices in the loader's order, including devices that stillray cannot use.
  Result<std::vector<DeviceInfo>> ListDevices() const;

  VkInstance handle() const { return handle_; }
  const InstanceFunctions& functions() const { return functions_; }
  PFN_vkGetInstanceProcAddr get_instance_proc_addr() const { return get_; }
  /// The messages outlive the instance, so that reports of leaked objects can be read.
  const std::shared_ptr<Messages>& messages() const { return messages_; }

 private:
  Instance() = default;
  VkInstance handle_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  PFN_vkGetInstanceProcAddr get_ = nullptr;
  InstanceFunctions functions_;
  std::shared_ptr<Messages> messages_;
};

/// Checks stillray's requirements: Vulkan 1.1, compute, the storage image formats.
Status CheckDevice(const InstanceFunctions& functions, VkPhysicalDevice device);

/// Selects a device by `choice`: of several usable devices the one with the highest rank, then the
/// first. \param choice "vulkan" (any usable device), "vulkan:N" (device N of the list) \return
/// kNotFound, kInvalidArgument: no such device; kUnsupported: it lacks a feature
Result<DeviceInfo> ChooseDevice(const std::vector<DeviceInfo>& devices, const std::string& choice);

}  // namespace stillray::gpu
