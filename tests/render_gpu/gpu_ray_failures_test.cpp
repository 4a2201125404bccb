// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Calls of Vulkan that trace rays by hardware and fail, one after the other: each is one line that
// says what failed, and nothing is left behind, which the validation layer would tell. Skipped on
// devices that do not trace rays by hardware.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <dlfcn.h>

#include <cstdlib>
#include <string>

#include "render/vulkan/gpu_accel.h"
#include "render_gpu/everything_scene.h"

namespace stillray::render {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RayFailures : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("FAILING_REAL", "libvulkan.so.1", 1);
    FailAt(nullptr, 0, VK_SUCCESS);
    const Status works = Open();
    const bool traces = works.ok() && device_->context().ray_tracing.offered;
    const std::string reason =
        !works.ok() ? works.message() : device_->info().name + " does not trace rays by hardware";
    Close();
    if (!traces) {
      GTEST_SKIP() << reason;
    }
  }
  void TearDown() override {
    FailAt(nullptr, 0, VK_SUCCESS);
    Close();
  }

  /// Lets the loader fail: see failing_loader.cpp. \param function  nullptr: nothing fails
  static void FailAt(const char* function, int count, VkResult result) {
    using Reset = void (*)();
    void* library = dlopen(STILLRAY_FAILING_LOADER, RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library, nullptr) << dlerror();
    reinterpret_cast<Reset>(dlsym(library, "failing_loader_reset"))();
    if (function == nullptr) {
      unsetenv("FAILING_CALL");
      return;
    }
    const std::string text =
        std::string(function) + ":" + std::to_string(count) + ":" + std::to_string(result);
    setenv("FAILING_CALL", text.c_str(), 1);
  }

  Status Open() {
    gpu::InstanceOptions options;
    options.validation = true;
    options.loader = STILLRAY_FAILING_LOADER;
    Result<std::shared_ptr<gpu::Instance>> instance = gpu::Instance::Create(options);
    STILLRAY_RETURN_IF_ERROR(instance.status());
    instance_ = *instance;
    const Result<std::vector<gpu::DeviceInfo>> devices = instance_->ListDevices();
    STILLRAY_RETURN_IF_ERROR(devices.status());
    const Result<gpu::DeviceInfo> chosen = gpu::ChooseDevice(*devices, "vulkan");
    STILLRAY_RETURN_IF_ERROR(chosen.status());
    Result<std::shared_ptr<gpu::Device>> device = gpu::Device::Create(instance_, *chosen);
    STILLRAY_RETURN_IF_ERROR(device.status());
    device_ = *device;
    return Status::Ok();
  }
  void Close() {
    device_.reset();
    const auto messages = instance_ != nullptr ? instance_->messages() : nullptr;
    instance_.reset();
    if (messages != nullptr) {
      EXPECT_THAT(messages->Take(), IsEmpty());
    }
  }

  /// Everything that is made once for a scene: bottom and top levels, pipelines and their tables.
  Status MakeAccel() {
    STILLRAY_RETURN_IF_ERROR(Open());
    const Scene scene = EverythingScene();
    SceneState state(scene);
    state.Update(0, 0);
    return GpuAccel::Create(device_.get(), state, TracingWay::kHardware).status();
  }

  std::shared_ptr<gpu::Instance> instance_;
  std::shared_ptr<gpu::Device> device_;
};

TEST_F(RayFailures, LeaveNothingBehind) {
  struct Failure {
    const char* function;
    VkResult result;
    const char* action;
    const char* meaning;
  };
  constexpr int kMostCalls = 40;
  for (const Failure& failure :
       {Failure{"vkCreateAccelerationStructureKHR", VK_ERROR_OUT_OF_DEVICE_MEMORY,
                "creating an acceleration structure", "out of device memory"},
        Failure{"vkCreateRayTracingPipelinesKHR", VK_ERROR_OUT_OF_HOST_MEMORY,
                "compiling the ray tracing shaders of ", "out of host memory"},
        Failure{"vkGetRayTracingShaderGroupHandlesKHR", VK_ERROR_OUT_OF_DEVICE_MEMORY,
                "reading the ray tracing shaders of ", "out of device memory"},
        Failure{"vkAllocateMemory", VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocating device memory",
                "out of device memory"},
        Failure{"vkQueueSubmit", VK_ERROR_DEVICE_LOST, "submitting work", "the device was lost"}}) {
    int failed = 0;
    for (bool fails = true; fails && failed <= kMostCalls; failed += fails ? 1 : 0) {
      FailAt(failure.function, failed + 1, failure.result);
      const Status status = MakeAccel();
      fails = !status.ok();
      if (fails) {
        EXPECT_THAT(status.message(), HasSubstr(failure.action)) << failure.function;
        EXPECT_THAT(status.message(), HasSubstr(failure.meaning)) << failure.function;
        EXPECT_EQ(status.message().find('\n'), std::string::npos) << failure.function;
      }
      Close();
      ASSERT_FALSE(HasFailure()) << failure.function << " " << failed + 1;
    }
    EXPECT_GT(failed, 0) << failure.function << " is not called";
    EXPECT_LE(failed, kMostCalls) << failure.function;
  }
}

}  // namespace
}  // namespace stillray::render
