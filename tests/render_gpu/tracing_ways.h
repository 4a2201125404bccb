// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Tests of everything that traces rays on a device, in both ways. Without hardware for it, or a
/// driver that does as if, those of the second way are skipped.
#pragma once

#include <string>
#include <vector>

#include "gpu/vulkan_test.h"
#include "render/vulkan/tracing_way.h"
#include "stillray/scene.h"

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

  /// All built-in scenes; on software drivers those that differ most in materials, lights and
  /// media: they compile shaders for each scene, slowly where they emulate ray tracing.
  std::vector<std::string> ScenesToCompare() const {
    if (!device_->context().is_software) {
      return BuiltinSceneNames();
    }
    if (GetParam() == TracingWay::kHardware) {
      return {"cornell", "spheres"};
    }
    return {"cornell", "mirrors", "faust", "colonnade"};
  }

  // For tests with many dispatches, which take ten times as long under the validation layer.
  void LeaveValidation() { ASSERT_NO_FATAL_FAILURE(Use(test::SharedVulkan::Get(false))); }
};

inline std::string NameOfWay(const ::testing::TestParamInfo<TracingWay>& info) {
  return info.param == TracingWay::kHardware ? "Hardware" : "Compute";
}

#define STILLRAY_IN_BOTH_WAYS(fixture) \
  INSTANTIATE_TEST_SUITE_P(            \
      , fixture, ::testing::Values(TracingWay::kCompute, TracingWay::kHardware), NameOfWay)

}  // namespace stillray::render
