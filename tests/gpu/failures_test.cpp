// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Failures of single Vulkan calls: every failure is one line that names the cause, and nothing
// leaks, which the validation layer would report.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "denoise/test_frames.h"
#include "gpu/device_test.h"
#include "gpu/failing_device.h"
#include "gpu/put_on_device.h"
#include "gpu/shared_pipelines.h"
#include "stillray/vulkan.hpp"

namespace stillray::failures_test {
namespace {

using ::testing::HasSubstr;

using test::Failure;

class Failures : public test::FailingDevice {
 protected:
  /// From nothing to two frames by the host API.
  Status Denoise() {
    STILLRAY_RETURN_IF_ERROR(Open());
    Result<Denoiser> denoiser =
        Denoiser::Create(PresetSettings("svgf").value(),
                         MakeDevice(std::make_shared<vulkan::VulkanBackend>(device_), "test"));
    STILLRAY_RETURN_IF_ERROR(denoiser.status());
    DenoisedFrame out;
    for (int i = 0; i < 2; ++i) {
      STILLRAY_RETURN_IF_ERROR(denoiser->Denoise(test::MakeBusyFrame(20, 12, i), &out));
    }
    return Status::Ok();
  }
  /// Two frames backward, then forward with their light, with a history that is saved and restored
  /// in between.
  Status PlayBothWays() {
    STILLRAY_RETURN_IF_ERROR(Open());
    const Device device = MakeDevice(std::make_shared<vulkan::VulkanBackend>(device_), "test");
    Result<Denoiser> backward = Denoiser::Create(PresetSettings("default").value(), device);
    STILLRAY_RETURN_IF_ERROR(backward.status());
    FutureLight future[2];
    for (const int i : {1, 0}) {
      STILLRAY_RETURN_IF_ERROR(backward->Accumulate(test::MakeBusyFrame(20, 12, i), &future[i]));
    }
    Result<Denoiser> forward = Denoiser::Create(PresetSettings("default").value(), device);
    STILLRAY_RETURN_IF_ERROR(forward.status());
    DenoisedFrame out;
    STILLRAY_RETURN_IF_ERROR(forward->Denoise(test::MakeBusyFrame(20, 12, 0), future[0], &out));
    const Result<std::vector<uint8_t>> saved = forward->SaveHistory();
    STILLRAY_RETURN_IF_ERROR(saved.status());
    STILLRAY_RETURN_IF_ERROR(forward->RestoreHistory(*saved));
    return forward->Denoise(test::MakeBusyFrame(20, 12, 1), future[1], &out);
  }
  /// Two frames with virtual guides that are on the device already. \param failure  from then on
  Status DenoiseWhatIsThere(const Failure& failure) {
    test::FailAt(nullptr, 0, VK_SUCCESS);
    STILLRAY_RETURN_IF_ERROR(Open());
    Frame frames[2];
    for (int i = 0; i < 2; ++i) {
      Frame f = test::MakeBusyFrame(20, 12, i);
      f.reflection.depth = f.guides.depth;
      f.reflection.motion = f.guides.motion;
      for (Signal& signal : f.signals) {
        signal.second_moment = f.guides.depth;
      }
      frames[i] = test::PutOnDevice(device_, f);
    }
    Result<Denoiser> denoiser = Denoiser::Create(
        Settings(), MakeDevice(std::make_shared<vulkan::VulkanBackend>(device_), "test"));
    STILLRAY_RETURN_IF_ERROR(denoiser.status());
    test::FailAt(failure);
    DenoisedFrame out;
    STILLRAY_RETURN_IF_ERROR(denoiser->Denoise(frames[0], &out));
    return denoiser->Denoise(frames[1], &out);
  }
  /// A denoiser in a renderer's own frame.
  Status Embed() {
    const VulkanContext context = {instance_->handle(), device_->context().physical,
                                   device_->context().device, instance_->get_instance_proc_addr()};
    VulkanOptions options;
    options.settings = PresetSettings("svgf").value();
    options.width = 20;
    options.height = 12;
    options.incomplete_guides = true;
    return VulkanDenoiser::Create(context, options).status();
  }
};

TEST_F(Failures, OfTheHostApiLeaveNothingBehind) {
  constexpr VkResult kLost = VK_ERROR_DEVICE_LOST;
  constexpr VkResult kDevice = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  constexpr VkResult kHost = VK_ERROR_OUT_OF_HOST_MEMORY;
  const Failure failures[] = {
      {"vkCreateInstance", 1, kHost, "creating an instance"},
      {"vkCreateInstance", 1, VK_ERROR_INCOMPATIBLE_DRIVER, "no Vulkan driver is installed"},
      {"vkEnumeratePhysicalDevices", 1, kHost, "listing devices"},
      {"vkCreateDevice", 1, kLost, "creating a device"},
      {"vkCreateDevice", 1, VK_ERROR_FEATURE_NOT_PRESENT, "the device lacks a feature"},
      {"vkCreateCommandPool", 1, kHost, "creating a command pool"},
      {"vkAllocateCommandBuffers", 1, kDevice, "creating a command buffer"},
      {"vkCreateFence", 1, kHost, "creating a fence"},
      {"vkCreateImage", 1, kHost, "creating an image"},
      {"vkCreateImage", 12, kDevice, "creating an image"},
      {"vkCreateBuffer", 1, kDevice, "creating a buffer"},
      {"vkAllocateMemory", 1, kDevice, "allocating device memory"},
      {"vkAllocateMemory", 3, kHost, "allocating device memory"},
      {"vkBindImageMemory", 2, kDevice, "binding an image"},
      {"vkBindBufferMemory", 1, kDevice, "binding a buffer"},
      {"vkCreateImageView", 3, kHost, "creating an image view"},
      {"vkMapMemory", 1, VK_ERROR_MEMORY_MAP_FAILED, "could not be mapped"},
      {"vkCreateDescriptorPool", 1, kDevice, "creating a descriptor pool"},
      {"vkCreateDescriptorSetLayout", 2, kHost, "creating a descriptor layout"},
      {"vkAllocateDescriptorSets", 4, VK_ERROR_OUT_OF_POOL_MEMORY, "allocating a descriptor set"},
      {"vkCreatePipelineLayout", 1, kHost, "creating a pipeline layout"},
      {"vkCreateShaderModule", 2, kHost, "compiling the shader"},
      {"vkCreateComputePipelines", 3, kDevice, "compiling the shader"},
      {"vkCreateQueryPool", 1, kDevice, "creating a query pool"},
      {"vkResetCommandPool", 2, kDevice, "resetting the command pool"},
      {"vkBeginCommandBuffer", 1, kDevice, "beginning a command buffer"},
      {"vkEndCommandBuffer", 1, kHost, "ending a command buffer"},
      {"vkQueueSubmit", 1, kLost, "submitting work"},
      {"vkQueueSubmit", 2, kLost, "submitting work"},
      {"vkWaitForFences", 1, kLost, "waiting for the device"},
      {"vkWaitForFences", 2, kLost, "waiting for the device"},
      {"vkResetFences", 1, kDevice, "resetting a fence"},
      {"vkFlushMappedMemoryRanges", 1, kDevice, "flushing mapped memory"},
      {"vkInvalidateMappedMemoryRanges", 1, kHost, "reading mapped memory"},
  };
  ASSERT_TRUE(Denoise().ok());
  Close();
  for (const Failure& failure : failures) {
    test::FailAt(failure);
    test::ExpectReported(Denoise(), failure);
    Close();
    ASSERT_FALSE(HasFailure()) << failure.function;
  }
}

TEST_F(Failures, ADeviceThatHangsIsReportedAndNotUsedAgain) {
  setenv("FAILING_DEVICE", "gpu", 1);
  gpu::InstanceOptions options;  // without validation, which reports that nothing is destroyed
  options.loader = STILLRAY_FAILING_LOADER;
  const std::shared_ptr<gpu::Instance> instance = *gpu::Instance::Create(options);
  const gpu::DeviceInfo info = *gpu::ChooseDevice(*instance->ListDevices(), "vulkan");
  const std::shared_ptr<gpu::Device> device = *gpu::Device::Create(instance, info);
  test::FailAt("vkWaitForFences", 1, VK_TIMEOUT);
  ASSERT_TRUE(device->Begin().ok());
  EXPECT_EQ(device->Run().message(),
            "Vulkan: waiting for the device: it hangs; its work was not finished after 10 s, "
            "expected fractions of a second (STILLRAY_GPU_TIMEOUT=N waits N s)");
  test::FailAt(nullptr, 0, VK_SUCCESS);
  EXPECT_THAT(device->Begin().status().message(), HasSubstr("it hangs"));
  unsetenv("FAILING_DEVICE");
}

TEST_F(Failures, OfBothWaysAndSavedHistoriesLeaveNothingBehind) {
  for (const Failure& failure :
       {Failure{"vkAllocateMemory", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocating device memory"},
        Failure{"vkQueueSubmit", 1, VK_ERROR_DEVICE_LOST, "submitting work"},
        Failure{"vkInvalidateMappedMemoryRanges", 1, VK_ERROR_OUT_OF_HOST_MEMORY,
                "reading mapped memory"}}) {
    FailEachCall(failure, 3, [&](const Failure& next) {
      test::FailAt(next);
      return PlayBothWays();
    });
  }
}

// Calls of the layer, of the rest, and more.
TEST_F(Failures, OfFramesOnTheDeviceLeaveNothingBehind) {
  for (const Failure& failure :
       {Failure{"vkAllocateMemory", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocating device memory"},
        Failure{"vkCreateQueryPool", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY, "creating a query pool"},
        Failure{"vkCreateDescriptorPool", 1, VK_ERROR_OUT_OF_HOST_MEMORY,
                "creating a descriptor pool"},
        Failure{"vkQueueSubmit", 1, VK_ERROR_DEVICE_LOST, "submitting work"}}) {
    FailEachCall(failure, 3, [&](const Failure& next) { return DenoiseWhatIsThere(next); });
  }
}

// The pipelines before the failure are used, those after it are created by the next denoiser.
TEST_F(Failures, OfOneDenoiserLeaveSharedPipelinesToTheNext) {
  ASSERT_TRUE(Open().ok());
  const auto created = [&] { return device_->context().pipelines->created(); };
  const auto make = [&] {
    Result<Denoiser> made =
        Denoiser::Create(PresetSettings("svgf").value(),
                         MakeDevice(std::make_shared<vulkan::VulkanBackend>(device_), "test"));
    DenoisedFrame out;
    return made.ok() ? made->Denoise(test::MakeBusyFrame(20, 12, 0), &out) : made.status();
  };
  ASSERT_TRUE(make().ok());
  const size_t all = created();
  for (const Failure& failure :
       {Failure{"vkCreatePipelineLayout", 4, VK_ERROR_OUT_OF_HOST_MEMORY, "a pipeline layout"},
        Failure{"vkCreateShaderModule", 4, VK_ERROR_OUT_OF_HOST_MEMORY, "compiling the shader"},
        Failure{"vkCreateComputePipelines", 4, VK_ERROR_OUT_OF_DEVICE_MEMORY,
                "compiling the shader"}}) {
    Close();
    ASSERT_TRUE(Open().ok());
    test::FailAt(failure);
    test::ExpectReported(make(), failure);
    EXPECT_EQ(created(), 3u) << failure.function;
    test::FailAt(nullptr, 0, VK_SUCCESS);
    const Status again = make();
    EXPECT_TRUE(again.ok()) << again.message();
    EXPECT_EQ(created(), all) << failure.function;
  }
}

TEST_F(Failures, OfAnEmbeddedDenoiserLeaveTheRenderersDeviceUsable) {
  const Failure failures[] = {
      {"vkCreateImage", 5, VK_ERROR_OUT_OF_DEVICE_MEMORY, "creating an image"},
      {"vkAllocateMemory", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY, "allocating device memory"},
      {"vkAllocateMemory", 2, VK_ERROR_OUT_OF_HOST_MEMORY, "allocating device memory"},
      {"vkCreateDescriptorPool", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY, "creating a descriptor pool"},
      {"vkCreateComputePipelines", 1, VK_ERROR_OUT_OF_HOST_MEMORY, "compiling the shader"},
  };
  ASSERT_TRUE(Open().ok());
  for (const Failure& failure : failures) {
    test::FailAt(failure);
    test::ExpectReported(Embed(), failure);
    test::FailAt(nullptr, 0, VK_SUCCESS);
    const Status again = Embed();
    EXPECT_TRUE(again.ok()) << again.message();
  }
}

}  // namespace
}  // namespace stillray::failures_test
