// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// A Vulkan loader that forwards to the real one and injects failures. It replaces the real one
// under its name, libvulkan.so.1, in a separate folder, and reads the environment:
//   FAILING_REAL     path or name of the real loader
//   FAILING_CALL     function:count:result, as vkQueueSubmit:3:-4: its third call returns -4, and
//                    all after it, as after a device was lost
//   FAILING_DEVICE   what devices are: "gpu" hardware, "old" of Vulkan 1.0, "poor" without features
#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#include <dlfcn.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <string_view>

namespace {

std::mutex mutex;
int calls = 0;

/// Whether this call of `name` is to fail, and how.
bool Fails(const char* name, VkResult* result) {
  const char* wanted = std::getenv("FAILING_CALL");
  char function[64] = {};
  int count = 0;
  int code = 0;
  if (wanted == nullptr || std::sscanf(wanted, "%63[^:]:%d:%d", function, &count, &code) != 3 ||
      std::strcmp(function, name) != 0) {
    return false;
  }
  const std::lock_guard lock(mutex);
  *result = static_cast<VkResult>(code);
  return ++calls >= count;
}

bool DevicesAre(std::string_view kind) {
  const char* wanted = std::getenv("FAILING_DEVICE");
  return wanted != nullptr && wanted == kind;
}

template <typename Self, typename Function>
struct Wrapper;

/// A function that returns a result. Waits are completed before they fail: objects in use must not
/// be destroyed, and the layers would report it.
template <typename Self, typename... Arguments>
struct Wrapper<Self, VkResult(VKAPI_PTR*)(Arguments...)> {
  static inline VkResult(VKAPI_PTR* real)(Arguments...) = nullptr;
  static VKAPI_ATTR VkResult VKAPI_CALL Call(Arguments... arguments) {
    VkResult result = VK_SUCCESS;
    if (!Fails(Self::kName, &result)) {
      return real(arguments...);
    }
    if (Self::kWaits) {
      real(arguments...);
    }
    return result;
  }
};

#define FAILING_FUNCTIONS(X)        \
  X(CreateInstance)                 \
  X(EnumeratePhysicalDevices)       \
  X(CreateDevice)                   \
  X(QueueSubmit)                    \
  X(WaitForFences)                  \
  X(ResetFences)                    \
  X(CreateFence)                    \
  X(CreateCommandPool)              \
  X(ResetCommandPool)               \
  X(AllocateCommandBuffers)         \
  X(BeginCommandBuffer)             \
  X(EndCommandBuffer)               \
  X(AllocateMemory)                 \
  X(MapMemory)                      \
  X(CreateBuffer)                   \
  X(BindBufferMemory)               \
  X(CreateImage)                    \
  X(BindImageMemory)                \
  X(CreateImageView)                \
  X(CreateShaderModule)             \
  X(CreateDescriptorSetLayout)      \
  X(CreateDescriptorPool)           \
  X(AllocateDescriptorSets)         \
  X(CreatePipelineLayout)           \
  X(CreateComputePipelines)         \
  X(CreateQueryPool)                \
  X(FlushMappedMemoryRanges)        \
  X(InvalidateMappedMemoryRanges)   \
  X(CreateAccelerationStructureKHR) \
  X(CreateRayTracingPipelinesKHR)   \
  X(GetRayTracingShaderGroupHandlesKHR)

#define DECLARE_FAILING(name)                                                         \
  struct Failing##name : Wrapper<Failing##name, PFN_vk##name> {                       \
    static constexpr const char* kName = "vk" #name;                                  \
    static constexpr bool kWaits = std::string_view("vk" #name) == "vkWaitForFences"; \
  };
FAILING_FUNCTIONS(DECLARE_FAILING)

PFN_vkGetInstanceProcAddr real_get_instance = nullptr;
PFN_vkGetDeviceProcAddr real_get_device = nullptr;
PFN_vkGetPhysicalDeviceProperties real_properties = nullptr;
PFN_vkGetPhysicalDeviceFeatures real_features = nullptr;

VKAPI_ATTR void VKAPI_CALL GetProperties(VkPhysicalDevice device,
                                         VkPhysicalDeviceProperties* properties) {
  real_properties(device, properties);
  if (DevicesAre("gpu")) {
    properties->deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  } else if (DevicesAre("old")) {
    properties->apiVersion = VK_API_VERSION_1_0;
  }
}

VKAPI_ATTR void VKAPI_CALL GetFeatures(VkPhysicalDevice device,
                                       VkPhysicalDeviceFeatures* features) {
  real_features(device, features);
  if (DevicesAre("poor")) {
    *features = {};
  }
}

template <typename Function>
PFN_vkVoidFunction Instead(PFN_vkVoidFunction found, Function* real, Function own) {
  *real = reinterpret_cast<Function>(found);
  return found != nullptr ? reinterpret_cast<PFN_vkVoidFunction>(own) : nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDevice(VkDevice device, const char* name);

PFN_vkVoidFunction Replaced(const std::string& name, PFN_vkVoidFunction found) {
#define REPLACE_FAILING(function)                                              \
  if (name == "vk" #function) {                                                \
    return Instead(found, &Failing##function::real, &Failing##function::Call); \
  }
  FAILING_FUNCTIONS(REPLACE_FAILING)
  if (name == "vkGetDeviceProcAddr") {
    return Instead(found, &real_get_device, &GetDevice);
  }
  if (name == "vkGetPhysicalDeviceProperties") {
    return Instead(found, &real_properties, &GetProperties);
  }
  if (name == "vkGetPhysicalDeviceFeatures") {
    return Instead(found, &real_features, &GetFeatures);
  }
  return found;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDevice(VkDevice device, const char* name) {
  return Replaced(name, real_get_device(device, name));
}

}  // namespace

extern "C" {

/// Resets the count of calls.
__attribute__((visibility("default"))) void failing_loader_reset() {
  const std::lock_guard lock(mutex);
  calls = 0;
}

__attribute__((visibility("default"))) PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance,
                                                                                const char* name) {
  if (real_get_instance == nullptr) {
    const char* path = std::getenv("FAILING_REAL");
    void* library = path != nullptr ? dlopen(path, RTLD_NOW | RTLD_LOCAL) : nullptr;
    if (library == nullptr) {
      return nullptr;
    }
    real_get_instance =
        reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"));
  }
  return Replaced(name, real_get_instance(instance, name));
}

}  // extern "C"
