// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Tests of everything that traces rays on a device, in both ways. Without hardware for it, or a
/// driver that does as if, those of the second way are skipped.
#pragma once

#include "gpu/vulkan_test.h"
#include "render/vulkan/tracing_way.h"

namespace stillray::render {

class TracingWaysTest : public test::VulkanTest, public ::testing::WithParamInterface<TracingWay> {
 protected:
  void SetUp() override {
    test::VulkanTest::SetUp();
    if (device_ != nullptr && GetParam() == TracingWay::kHardware &&
        !device_->context().ray_tracing.offered) {
      GTEST_SKIP() << device_->info().name << " does not trace rays by hardware";
    }
  }

  // For tests with many dispatches, which take ten times as long under the validation layer.
  void LeaveValidation() {
    const Result<std::shared_ptr<gpu::Instance>> instance = gpu::Instance::Create();
    ASSERT_TRUE(instance.ok());
    const Result<std::vector<gpu::DeviceInfo>> devices = (*instance)->ListDevices();
    const Result<gpu::DeviceInfo> chosen = gpu::ChooseDevice(*devices, "vulkan");
    const Result<std::shared_ptr<gpu::Device>> device = gpu::Device::Create(*instance, *chosen);
    ASSERT_TRUE(device.ok());
    device_ = *device;
  }
};

inline std::string NameOfWay(const ::testing::TestParamInfo<TracingWay>& info) {
  return info.param == TracingWay::kHardware ? "Hardware" : "Compute";
}

#define STILLRAY_IN_BOTH_WAYS(fixture) \
  INSTANTIATE_TEST_SUITE_P(            \
      , fixture, ::testing::Values(TracingWay::kCompute, TracingWay::kHardware), NameOfWay)

}  // namespace stillray::render
