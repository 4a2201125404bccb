// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/functions.h"

#include <dlfcn.h>

#include <fmt/format.h>

namespace stillray::gpu {
namespace {

const char* Meaning(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return "out of device memory";
    case VK_ERROR_DEVICE_LOST:
      return "the device was lost (the driver reset it or it was removed)";
    case VK_ERROR_INITIALIZATION_FAILED:
      return "the driver could not be initialised";
    case VK_ERROR_MEMORY_MAP_FAILED:
      return "device memory could not be mapped";
    case VK_ERROR_LAYER_NOT_PRESENT:
      return "a layer is not installed (Debian: vulkan-validationlayers)";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      return "the driver lacks an extension";
    case VK_ERROR_FEATURE_NOT_PRESENT:
      return "the device lacks a feature";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
      return "no Vulkan driver is installed (Debian: mesa-vulkan-drivers)";
    case VK_ERROR_TOO_MANY_OBJECTS:
      return "too many objects of this kind";
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
      return "the device lacks an image format";
    case VK_ERROR_FRAGMENTED_POOL:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
      return "a descriptor pool is exhausted";
    case VK_TIMEOUT:
      return "timed out";
    default:
      return "unexpected result";
  }
}

}  // namespace

Status ToStatus(VkResult result, const char* action) {
  if (result == VK_SUCCESS) {
    return Status::Ok();
  }
  std::string text =
      fmt::format("Vulkan: {}: {} ({})", action, Meaning(result), static_cast<int>(result));
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      return Status::OutOfMemory(std::move(text));
    case VK_ERROR_FRAGMENTED_POOL:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
      return Status::Internal(std::move(text));
    default:
      return Status::Unsupported(std::move(text));
  }
}

Result<GlobalFunctions> OpenLoader(const char* library) {
  const char* name = library != nullptr ? library : "libvulkan.so.1";
  void* handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    return Status::Unsupported(
        fmt::format("Vulkan: the loader {} is not on this machine (Debian: libvulkan1)", name));
  }
  GlobalFunctions f;
  f.GetInstanceProcAddr =
      reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(handle, "vkGetInstanceProcAddr"));
  if (f.GetInstanceProcAddr == nullptr) {
    return Status::Unsupported(
        fmt::format("Vulkan: {} has no vkGetInstanceProcAddr: it is no Vulkan loader", name));
  }
#define STILLRAY_VK_LOAD_(name) \
  f.name = reinterpret_cast<PFN_vk##name>(f.GetInstanceProcAddr(nullptr, "vk" #name));
  STILLRAY_VK_GLOBAL_FUNCTIONS(STILLRAY_VK_LOAD_)
#undef STILLRAY_VK_LOAD_
  if (f.CreateInstance == nullptr || f.EnumerateInstanceVersion == nullptr) {
    return Status::Unsupported(fmt::format("Vulkan: {} is of Vulkan 1.0, expected 1.1", name));
  }
  return f;
}

#define STILLRAY_VK_REQUIRE_(name)                                                \
  f.name = reinterpret_cast<PFN_vk##name>(get(handle, "vk" #name));               \
  if (f.name == nullptr) {                                                        \
    return Status::Unsupported("Vulkan: the driver lacks the function vk" #name); \
  }
#define STILLRAY_VK_OPTIONAL_(name) \
  f.name = reinterpret_cast<PFN_vk##name>(get(handle, "vk" #name));

Result<InstanceFunctions> LoadInstanceFunctions(PFN_vkGetInstanceProcAddr get, VkInstance handle) {
  InstanceFunctions f;
  STILLRAY_VK_INSTANCE_FUNCTIONS(STILLRAY_VK_REQUIRE_)
  STILLRAY_VK_DEBUG_FUNCTIONS(STILLRAY_VK_OPTIONAL_)
  return f;
}

Result<DeviceFunctions> LoadDeviceFunctions(PFN_vkGetDeviceProcAddr get, VkDevice handle) {
  DeviceFunctions f;
  STILLRAY_VK_DEVICE_FUNCTIONS(STILLRAY_VK_REQUIRE_)
  return f;
}

Status LoadRayTracingFunctions(PFN_vkGetDeviceProcAddr get, VkDevice handle,
                               DeviceFunctions* functions) {
  DeviceFunctions& f = *functions;
  STILLRAY_VK_RAY_TRACING_FUNCTIONS(STILLRAY_VK_REQUIRE_)
  return Status::Ok();
}

Status LoadSharingFunctions(PFN_vkGetDeviceProcAddr get, VkDevice handle,
                            DeviceFunctions* functions) {
  DeviceFunctions& f = *functions;
  STILLRAY_VK_SHARING_FUNCTIONS(STILLRAY_VK_REQUIRE_)
  return Status::Ok();
}

Status LoadLabelFunctions(PFN_vkGetDeviceProcAddr get, VkDevice handle,
                          DeviceFunctions* functions) {
  DeviceFunctions& f = *functions;
  STILLRAY_VK_LABEL_FUNCTIONS(STILLRAY_VK_REQUIRE_)
  return Status::Ok();
}

Status LoadStatisticsFunctions(PFN_vkGetDeviceProcAddr get, VkDevice handle,
                               DeviceFunctions* functions) {
  DeviceFunctions& f = *functions;
  STILLRAY_VK_STATISTICS_FUNCTIONS(STILLRAY_VK_REQUIRE_)
  return Status::Ok();
}

}  // namespace stillray::gpu
