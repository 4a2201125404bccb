// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Failures of single Vulkan calls of hardware ray tracing: each is one line that names the cause,
// and nothing leaks, which the validation layer would report. Skipped on devices without ray
// tracing hardware.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gpu/failing_device.h"
#include "render/vulkan/gpu_accel.h"
#include "render_gpu/everything_scene.h"

namespace stillray::render {
namespace {

using ::testing::HasSubstr;

class RayFailures : public test::FailingDevice {
 protected:
  Status Suits() const override {
    return device_->context().ray_tracing.offered
               ? Status::Ok()
               : Status::Unsupported(device_->info().name + " does not trace rays by hardware");
  }

  /// Everything that is made once for a scene: bottom and top levels, pipelines and their tables.
  Status MakeAccel() {
    STILLRAY_RETURN_IF_ERROR(Open());
    const Scene scene = EverythingScene();
    SceneState state(scene);
    state.Update(0, 0);
    return GpuAccel::Create(device_.get(), state, TracingWay::kHardware).status();
  }
};

TEST_F(RayFailures, LeaveNothingBehind) {
  struct Failure {
    const char* function;
    VkResult result;
    const char* action;
  };
  constexpr int kMostCalls = 40;
  for (const Failure& failure :
       {Failure{"vkCreateAccelerationStructureKHR", VK_ERROR_OUT_OF_DEVICE_MEMORY,
                "creating an acceleration structure"},
        Failure{"vkCreateRayTracingPipelinesKHR", VK_ERROR_OUT_OF_HOST_MEMORY,
                "compiling the ray tracing shaders of "},
        Failure{"vkGetRayTracingShaderGroupHandlesKHR", VK_ERROR_OUT_OF_DEVICE_MEMORY,
                "reading the ray tracing shaders of "},
        Failure{"vkAllocateMemory", VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocating device memory"},
        Failure{"vkQueueSubmit", VK_ERROR_DEVICE_LOST, "submitting work"}}) {
    int failed = 0;
    for (bool fails = true; fails && failed <= kMostCalls; failed += fails ? 1 : 0) {
      test::FailAt(failure.function, failed + 1, failure.result);
      const Status status = MakeAccel();
      fails = !status.ok();
      if (fails) {
        EXPECT_THAT(status.message(), HasSubstr(failure.action)) << failure.function;
        EXPECT_THAT(status.message(), HasSubstr(test::MeaningOf(failure.result)))
            << failure.function;
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
