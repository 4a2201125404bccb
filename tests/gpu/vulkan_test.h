// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Common to tests on Vulkan: an instance with the validation layer, whose messages are all
/// failures, and a device, hardware or software. Skipped without a driver.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/record_largest.h"
#include "gpu/device.h"

namespace stillray::test {

/// An instance and a device of it, or why there is none.
struct OpenedVulkan {
  std::shared_ptr<gpu::Messages> messages;
  std::shared_ptr<gpu::Instance> instance;
  std::shared_ptr<gpu::Device> device;
  bool validates = false;  ///< the validation layer is watching
  std::string missing;     ///< no driver: why; else empty
  Status status;           ///< of opening the device of a driver

  /// Of the instance and the device, which are destroyed. \return what the layer has reported
  std::vector<std::string> Close() {
    device.reset();
    instance.reset();
    return messages != nullptr ? messages->Take() : std::vector<std::string>();
  }
};

inline OpenedVulkan OpenVulkan(bool validation) {
  OpenedVulkan opened;
  gpu::InstanceOptions options;
  options.validation = validation;
  Result<std::shared_ptr<gpu::Instance>> instance = gpu::Instance::Create(options);
  opened.validates = validation && instance.ok();
  if (!instance.ok() && validation) {  // the layer may be missing where a driver is not
    options.validation = false;
    instance = gpu::Instance::Create(options);
  }
  if (!instance.ok()) {
    opened.missing = instance.status().message();
    return opened;
  }
  opened.instance = *instance;
  opened.messages = opened.instance->messages();
  const Result<std::vector<gpu::DeviceInfo>> devices = opened.instance->ListDevices();
  if (!devices.ok()) {
    opened.status = devices.status();
    return opened;
  }
  const Result<gpu::DeviceInfo> chosen = gpu::ChooseDevice(*devices, "vulkan");
  if (!chosen.ok()) {
    opened.missing = chosen.status().message();
    return opened;
  }
  Result<std::shared_ptr<gpu::Device>> device = gpu::Device::Create(opened.instance, *chosen);
  opened.status = device.status();
  if (device.ok()) {
    opened.device = *device;
  }
  return opened;
}

/// The devices that the tests of a program share: pipelines belong to a device, and a software
/// driver takes seconds to make those of a denoiser.
class SharedVulkan : public ::testing::Environment {
 public:
  /// Opened by the first test that uses it.
  static const OpenedVulkan& Get(bool validation) {
    std::unique_ptr<OpenedVulkan>& opened = environment_->opened_[validation ? 1 : 0];
    if (opened == nullptr) {
      opened = std::make_unique<OpenedVulkan>(OpenVulkan(validation));
    }
    return *opened;
  }

  /// Objects of tests must be destroyed by now: the layer reports leaks.
  void TearDown() override {
    for (std::unique_ptr<OpenedVulkan>& opened : opened_) {
      for (const std::string& message :
           opened != nullptr ? opened->Close() : std::vector<std::string>()) {
        ADD_FAILURE() << "after all tests: " << message;
      }
      opened.reset();
    }
  }

 private:
  static SharedVulkan* const environment_;
  std::unique_ptr<OpenedVulkan> opened_[2];
};

// GoogleTest owns it.
inline SharedVulkan* const SharedVulkan::environment_ =
    static_cast<SharedVulkan*>(::testing::AddGlobalTestEnvironment(new SharedVulkan));

/// A test on an instance and a device that others may use too.
class VulkanTest : public ::testing::Test {
 protected:
  void SetUp() override { Use(SharedVulkan::Get(true)); }
  void TearDown() override {
    device_.reset();
    instance_.reset();
    if (messages_ != nullptr) {
      for (const std::string& message : messages_->Take()) {
        ADD_FAILURE() << message;
      }
    }
  }

  void Use(const OpenedVulkan& opened) {
    if (!opened.missing.empty()) {
      GTEST_SKIP() << opened.missing;
    }
    RecordProperty("validation layer", opened.validates ? "watches" : "is not installed");
    ASSERT_TRUE(opened.status.ok()) << opened.status.message();
    validates_ = opened.validates;
    messages_ = opened.messages;
    instance_ = opened.instance;
    device_ = opened.device;
  }

  /// For tests of what a device makes when it is new.
  void UseNewDevice() {
    Result<std::shared_ptr<gpu::Device>> made = gpu::Device::Create(instance_, device_->info());
    ASSERT_TRUE(made.ok()) << made.status().message();
    device_ = *made;
  }

  bool validates_ = false;  ///< the validation layer is watching
  std::shared_ptr<gpu::Messages> messages_;
  std::shared_ptr<gpu::Instance> instance_;
  std::shared_ptr<gpu::Device> device_;
};

/// A test of instances and devices themselves, on its own ones.
class OwnVulkanTest : public VulkanTest {
 protected:
  void SetUp() override { Use(OpenVulkan(true)); }
};

}  // namespace stillray::test
