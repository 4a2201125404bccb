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

class VulkanTest : public ::testing::Test {
 protected:
  void SetUp() override {
    gpu::InstanceOptions options;
    options.validation = true;
    Result<std::shared_ptr<gpu::Instance>> instance = gpu::Instance::Create(options);
    validates_ = instance.ok();
    if (!validates_) {  // the layer may be missing where a driver is not
      options.validation = false;
      instance = gpu::Instance::Create(options);
    }
    if (!instance.ok()) {
      GTEST_SKIP() << instance.status().message();
    }
    RecordProperty("validation layer", validates_ ? "watches" : "is not installed");
    instance_ = *instance;
    messages_ = instance_->messages();
    const Result<std::vector<gpu::DeviceInfo>> devices = instance_->ListDevices();
    ASSERT_TRUE(devices.ok()) << devices.status().message();
    const Result<gpu::DeviceInfo> chosen = gpu::ChooseDevice(*devices, "vulkan");
    if (!chosen.ok()) {
      GTEST_SKIP() << chosen.status().message();
    }
    Result<std::shared_ptr<gpu::Device>> device = gpu::Device::Create(instance_, *chosen);
    ASSERT_TRUE(device.ok()) << device.status().message();
    device_ = *device;
  }

  /// The test's own objects must be destroyed by now: the layer reports leaks.
  void TearDown() override {
    device_.reset();
    instance_.reset();
    if (messages_ != nullptr) {
      for (const std::string& message : messages_->Take()) {
        ADD_FAILURE() << message;
      }
    }
  }

  bool validates_ = false;  ///< the validation layer is watching
  std::shared_ptr<gpu::Messages> messages_;
  std::shared_ptr<gpu::Instance> instance_;
  std::shared_ptr<gpu::Device> device_;
};

}  // namespace stillray::test
