// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/instance.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/device_choice.h"

namespace stillray::gpu {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL OnMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data,
                                         void* messages) {
  static_cast<Messages*>(messages)->Add(data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT MessengerInfo(Messages* messages) {
  VkDebugUtilsMessengerCreateInfoEXT info = {};
  info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
  info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                         VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  info.pfnUserCallback = OnMessage;
  info.pUserData = messages;
  return info;
}

bool HasValidationLayer(const GlobalFunctions& vk) {
  uint32_t count = 0;
  vk.EnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vk.EnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.begin() + count, [](const VkLayerProperties& layer) {
    return std::strcmp(layer.layerName, kValidationLayer) == 0;
  });
}

const char* KindName(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "software";
    default:
      return "other";
  }
}

/// Order of preference, needed since loaders list integrated GPUs first on some machines.
int RankOf(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return 4;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return 3;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return 1;
    default:
      return 0;
  }
}

uint64_t DeviceMemory(const InstanceFunctions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceMemoryProperties memory = {};
  vk.GetPhysicalDeviceMemoryProperties(device, &memory);
  uint64_t most = 0;
  for (uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
    if ((memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0) {
      most = std::max<uint64_t>(most, memory.memoryHeaps[i].size);
    }
  }
  return most;
}

std::string DriverName(const InstanceFunctions& vk, VkPhysicalDevice device, uint32_t api_version,
                       uint32_t driver_version) {
  if (api_version < VK_API_VERSION_1_2) {  // in the core of Vulkan 1.2
    return fmt::format("driver {:#x}", driver_version);
  }
  VkPhysicalDeviceDriverProperties driver = {};
  driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceProperties2 properties = {};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &driver;
  vk.GetPhysicalDeviceProperties2(device, &properties);
  return fmt::format("{} {}", driver.driverName, driver.driverInfo);
}

DeviceInfo Describe(const InstanceFunctions& vk, VkPhysicalDevice device, int index) {
  VkPhysicalDeviceProperties properties = {};
  vk.GetPhysicalDeviceProperties(device, &properties);
  DeviceInfo info;
  info.handle = device;
  info.index = index;
  info.name = properties.deviceName;
  info.kind = KindName(properties.deviceType);
  info.is_gpu = properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_CPU &&
                properties.deviceType != VK_PHYSICAL_DEVICE_TYPE_OTHER;
  info.rank = RankOf(properties.deviceType);
  info.api_version = properties.apiVersion;
  info.memory_bytes = DeviceMemory(vk, device);
  info.usable = CheckDevice(vk, device);
  info.ray_tracing = FindRayTracing(vk, device);
  info.sharing = FindMemorySharing(vk, device);
  info.driver = properties.apiVersion < VK_API_VERSION_1_1
                    ? fmt::format("driver {:#x}", properties.driverVersion)
                    : DriverName(vk, device, properties.apiVersion, properties.driverVersion);
  return info;
}

}  // namespace

void Messages::Add(std::string text) {
  const std::lock_guard lock(mutex_);
  list_.push_back(std::move(text));
}

std::vector<std::string> Messages::Take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(list_, {});
}

Result<std::shared_ptr<Instance>> Instance::Create(const InstanceOptions& options) {
  const Result<GlobalFunctions> opened = OpenLoader(options.loader);
  if (!opened.ok()) {
    return opened.status();
  }
  const GlobalFunctions& vk = *opened;
  if (options.validation && !HasValidationLayer(vk)) {
    return Status::Unsupported(
        fmt::format("Vulkan: the layer {} is not installed (Debian: vulkan-validationlayers)",
                    kValidationLayer));
  }
  std::shared_ptr<Instance> made(new Instance());
  made->messages_ = std::make_shared<Messages>();
  VkApplicationInfo application = {};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.pApplicationName = "stillray";
  application.apiVersion = VK_API_VERSION_1_1;
  VkDebugUtilsMessengerCreateInfoEXT messenger = MessengerInfo(made->messages_.get());
  const VkValidationFeatureEnableEXT enabled =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features = {};
  features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
  features.pNext = &messenger;
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &enabled;
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  VkInstanceCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;
  if (options.validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(vk.CreateInstance(&info, nullptr, &made->handle_), "creating an instance"));
  made->get_ = vk.GetInstanceProcAddr;
  Result<InstanceFunctions> loaded = LoadInstanceFunctions(vk.GetInstanceProcAddr, made->handle_);
  if (!loaded.ok()) {
    return loaded.status();
  }
  made->functions_ = *loaded;
  if (options.validation && made->functions_.CreateDebugUtilsMessengerEXT != nullptr) {
    STILLRAY_RETURN_IF_ERROR(ToStatus(made->functions_.CreateDebugUtilsMessengerEXT(
                                          made->handle_, &messenger, nullptr, &made->messenger_),
                                      "listening to the validation layer"));
  }
  return made;
}

Instance::~Instance() {
  if (messenger_ != VK_NULL_HANDLE) {
    functions_.DestroyDebugUtilsMessengerEXT(handle_, messenger_, nullptr);
  }
  if (handle_ != VK_NULL_HANDLE && functions_.DestroyInstance != nullptr) {
    functions_.DestroyInstance(handle_, nullptr);
  }
}

Result<std::vector<DeviceInfo>> Instance::ListDevices() const {
  uint32_t count = 0;
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(functions_.EnumeratePhysicalDevices(handle_, &count, nullptr), "listing devices"));
  std::vector<VkPhysicalDevice> handles(count);
  const VkResult listed = functions_.EnumeratePhysicalDevices(handle_, &count, handles.data());
  STILLRAY_RETURN_IF_ERROR(
      ToStatus(listed == VK_INCOMPLETE ? VK_SUCCESS : listed, "listing devices"));
  std::vector<DeviceInfo> devices;
  for (uint32_t i = 0; i < count; ++i) {
    devices.push_back(Describe(functions_, handles[i], static_cast<int>(i)));
  }
  return devices;
}

Status CheckDevice(const InstanceFunctions& vk, VkPhysicalDevice device) {
  VkPhysicalDeviceProperties properties = {};
  vk.GetPhysicalDeviceProperties(device, &properties);
  if (properties.apiVersion < VK_API_VERSION_1_1) {
    return Status::Unsupported(fmt::format(
        "{}: the driver offers Vulkan {}.{}, expected 1.1 or newer", properties.deviceName,
        VK_API_VERSION_MAJOR(properties.apiVersion), VK_API_VERSION_MINOR(properties.apiVersion)));
  }
  VkPhysicalDeviceFeatures features = {};
  vk.GetPhysicalDeviceFeatures(device, &features);
  if (features.shaderStorageImageExtendedFormats == VK_FALSE) {
    return Status::Unsupported(
        fmt::format("{}: the device lacks the feature shaderStorageImageExtendedFormats",
                    properties.deviceName));
  }
  constexpr VkFormatFeatureFlags kWanted =
      VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
  constexpr std::array kFormats = {std::pair{VK_FORMAT_R16G16B16A16_SFLOAT, "R16G16B16A16_SFLOAT"},
                                   std::pair{VK_FORMAT_R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT"},
                                   std::pair{VK_FORMAT_R16_SFLOAT, "R16_SFLOAT"},
                                   std::pair{VK_FORMAT_R16_UNORM, "R16_UNORM"},
                                   std::pair{VK_FORMAT_R32_SFLOAT, "R32_SFLOAT"},
                                   std::pair{VK_FORMAT_R32G32_SFLOAT, "R32G32_SFLOAT"},
                                   std::pair{VK_FORMAT_R32_UINT, "R32_UINT"},
                                   std::pair{VK_FORMAT_R32G32_UINT, "R32G32_UINT"},
                                   std::pair{VK_FORMAT_R32G32B32A32_UINT, "R32G32B32A32_UINT"}};
  for (const auto& [format, name] : kFormats) {
    VkFormatProperties offered = {};
    vk.GetPhysicalDeviceFormatProperties(device, format, &offered);
    if ((offered.optimalTilingFeatures & kWanted) != kWanted) {
      return Status::Unsupported(
          fmt::format("{}: the device cannot store images of format {} from shaders",
                      properties.deviceName, name));
    }
  }
  constexpr uint32_t kMostSampled = 37;
  constexpr uint32_t kMostStored = 8;
  const VkPhysicalDeviceLimits& limits = properties.limits;
  if (limits.maxPerStageDescriptorSampledImages < kMostSampled ||
      limits.maxPerStageDescriptorStorageImages < kMostStored) {
    return Status::Unsupported(fmt::format(
        "{}: a shader may read {} and write {} images on this device, expected {} and {}",
        properties.deviceName, limits.maxPerStageDescriptorSampledImages,
        limits.maxPerStageDescriptorStorageImages, kMostSampled, kMostStored));
  }
  // Workgroup size of the reduction shaders; all other shaders use 128.
  constexpr uint32_t kMostInvocations = 256;
  if (limits.maxComputeWorkGroupInvocations < kMostInvocations ||
      limits.maxComputeWorkGroupSize[0] < kMostInvocations) {
    return Status::Unsupported(
        fmt::format("{}: a workgroup may have {} invocations, {} along x, on this device, expected "
                    "{}",
                    properties.deviceName, limits.maxComputeWorkGroupInvocations,
                    limits.maxComputeWorkGroupSize[0], kMostInvocations));
  }
  return Status::Ok();
}

Result<DeviceInfo> ChooseDevice(const std::vector<DeviceInfo>& devices, const std::string& choice) {
  if (devices.empty()) {
    return Status::NotFound("Vulkan: the drivers of this machine offer no device");
  }
  if (choice == "vulkan") {
    const auto rank = [](const DeviceInfo& d) {
      return (d.usable.ok() ? 100 : 0) + (d.is_gpu ? 10 : 0) + d.rank;
    };
    const auto best = std::max_element(
        devices.begin(), devices.end(),
        [&](const DeviceInfo& a, const DeviceInfo& b) { return rank(a) < rank(b); });
    return best->usable.ok() ? Result<DeviceInfo>(*best) : Result<DeviceInfo>(best->usable);
  }
  constexpr std::string_view kPrefix = "vulkan:";
  int index = -1;
  const char* end = choice.data() + choice.size();
  const bool named = choice.compare(0, kPrefix.size(), kPrefix) == 0;
  const auto parsed = named ? std::from_chars(choice.data() + kPrefix.size(), end, index)
                            : std::from_chars_result{nullptr, std::errc::invalid_argument};
  if (parsed.ec != std::errc() || parsed.ptr != end || index < 0) {
    return UnknownDeviceChoice(choice);
  }
  if (static_cast<size_t>(index) >= devices.size()) {
    return Status::NotFound(fmt::format(
        "device is '{}', but this machine has vulkan:0 to vulkan:{}", choice, devices.size() - 1));
  }
  const DeviceInfo& chosen = devices[static_cast<size_t>(index)];
  return chosen.usable.ok() ? Result<DeviceInfo>(chosen) : Result<DeviceInfo>(chosen.usable);
}

}  // namespace stillray::gpu
