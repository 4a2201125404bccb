// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/functions.h"

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#include <algorithm>
#include <iterator>
#include <vector>

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

// File names of the loader, in order of preference, and its source for the error message.
#if defined(_WIN32)
constexpr const char* kLoaderNames[] = {"vulkan-1.dll"};
constexpr const char* kLoaderSource = "it comes with the driver of the GPU";
#elif defined(__APPLE__)
constexpr const char* kLoaderNames[] = {"libvulkan.1.dylib", "libvulkan.dylib",
                                        "/usr/local/lib/libvulkan.1.dylib",
                                        "/opt/homebrew/lib/libvulkan.1.dylib", "libMoltenVK.dylib"};
constexpr const char* kLoaderSource = "it comes with the Vulkan SDK";
#else
constexpr const char* kLoaderNames[] = {"libvulkan.so.1"};
constexpr const char* kLoaderSource = "Debian: libvulkan1";
#endif

/// Opens a loader, which is never closed. \param get [out] its entry point; nullptr if missing
/// \return whether the library exists
bool OpenLibrary(const char* name, PFN_vkGetInstanceProcAddr* get) {
  constexpr const char* kEntry = "vkGetInstanceProcAddr";
#ifdef _WIN32
  const HMODULE handle = LoadLibraryA(name);
  void* entry =
      handle != nullptr ? reinterpret_cast<void*>(GetProcAddress(handle, kEntry)) : nullptr;
#else
  void* handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  void* entry = handle != nullptr ? dlsym(handle, kEntry) : nullptr;
#endif
  *get = reinterpret_cast<PFN_vkGetInstanceProcAddr>(entry);
  return handle != nullptr;
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
  const std::vector<const char*> names =
      library != nullptr
          ? std::vector<const char*>{library}
          : std::vector<const char*>(std::begin(kLoaderNames), std::end(kLoaderNames));
  GlobalFunctions f;
  const auto found = std::ranges::find_if(
      names, [&](const char* name) { return OpenLibrary(name, &f.GetInstanceProcAddr); });
  if (found == names.end()) {
    return Status::Unsupported(fmt::format("Vulkan: the loader {} is not on this machine ({})",
                                           names.front(), kLoaderSource));
  }
  const char* name = *found;
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
