// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A device with injected failures: see failing_loader.cpp. For programs that define
/// STILLRAY_FAILING_LOADER, its path.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <dlfcn.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gpu/device.h"

namespace stillray::test {

/// The result of one call of a Vulkan function, and its report.
struct Failure {
  const char* function;
  int count;  ///< of the call that fails; 1: the first
  VkResult result;
  const char* action;  ///< a part of the message
};

/// Calls `failing_loader_reset`, and has the loader fail the `count`-th call of a function from now
/// on. \param function  nullptr: nothing fails
inline void FailAt(const char* function, int count, VkResult result) {
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

/// The name of a failure in messages.
inline const char* MeaningOf(VkResult result) {
  return result == VK_ERROR_DEVICE_LOST            ? "the device was lost"
         : result == VK_ERROR_OUT_OF_DEVICE_MEMORY ? "out of device memory"
         : result == VK_ERROR_OUT_OF_HOST_MEMORY   ? "out of host memory"
                                                   : "(";
}

inline void FailAt(const Failure& failure) {
  FailAt(failure.function, failure.count, failure.result);
}

/// Expects one line that names the action and the cause.
inline void ExpectReported(const Status& status, const Failure& failure) {
  ASSERT_FALSE(status.ok()) << failure.function;
  EXPECT_THAT(status.message(), ::testing::HasSubstr(failure.action)) << failure.function;
  EXPECT_THAT(status.message(), ::testing::HasSubstr(MeaningOf(failure.result)))
      << failure.function;
  EXPECT_EQ(status.message().find('\n'), std::string::npos) << failure.function;
}

/// Skipped where no device works.
class FailingDevice : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("FAILING_REAL", "libvulkan.so.1", 1);
    FailAt(nullptr, 0, VK_SUCCESS);
    Status works = Open();
    if (works.ok()) {
      works = Suits();
    }
    Close();
    if (!works.ok()) {
      GTEST_SKIP() << works.message();
    }
  }
  void TearDown() override {
    FailAt(nullptr, 0, VK_SUCCESS);
    Close();
  }

  /// Whether the open device supports the tested feature.
  virtual Status Suits() const { return Status::Ok(); }

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

  /// Nothing may leak: the validation layer would report it.
  void Close() {
    device_.reset();
    const auto messages = instance_ != nullptr ? instance_->messages() : nullptr;
    instance_.reset();
    if (messages != nullptr) {
      EXPECT_THAT(messages->Take(), ::testing::IsEmpty());
    }
  }

  /// Runs again and again, with the first, the second, ... call of a function failing, until `run`
  /// makes fewer calls than that, and closes the device after each run.
  ///
  /// \param failure       its count is not used
  /// \param least_failed  calls that `run` makes at least
  void FailEachCall(Failure failure, int least_failed,
                    const std::function<Status(const Failure&)>& run) {
    constexpr int kMostCalls = 60;
    bool failed = true;
    for (failure.count = 1; failed && failure.count <= kMostCalls; ++failure.count) {
      const Status status = run(failure);
      failed = !status.ok();
      if (failed) {
        ExpectReported(status, failure);
      }
      Close();
      ASSERT_FALSE(HasFailure()) << failure.function << " " << failure.count;
    }
    EXPECT_FALSE(failed) << failure.function;
    EXPECT_GE(failure.count - 2, least_failed)
        << failure.function;  // the last run is without a failure
  }

  std::shared_ptr<gpu::Instance> instance_;
  std::shared_ptr<gpu::Device> device_;
};

}  // namespace stillray::test
