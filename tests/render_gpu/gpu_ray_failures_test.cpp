// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Failures of single Vulkan calls of hardware ray tracing: each is one line that names the cause,
// and nothing leaks, which the validation layer would report. Skipped on devices without ray
// tracing hardware.
#include <gtest/gtest.h>

#include "gpu/failing_device.h"
#include "render/vulkan/gpu_accel.h"
#include "render_gpu/everything_scene.h"

namespace stillray::render {
namespace {

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
  using test::Failure;
  for (const Failure& failure :
       {Failure{"vkCreateAccelerationStructureKHR", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY,
                "creating an acceleration structure"},
        Failure{"vkCreateRayTracingPipelinesKHR", 1, VK_ERROR_OUT_OF_HOST_MEMORY,
                "compiling the ray tracing shaders of "},
        Failure{"vkGetRayTracingShaderGroupHandlesKHR", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY,
                "reading the ray tracing shaders of "},
        Failure{"vkAllocateMemory", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocating device memory"},
        Failure{"vkQueueSubmit", 1, VK_ERROR_DEVICE_LOST, "submitting work"}}) {
    FailEachCall(failure, 1, [&](const Failure& next) {
      test::FailAt(next);
      return MakeAccel();
    });
  }
}

}  // namespace
}  // namespace stillray::render
