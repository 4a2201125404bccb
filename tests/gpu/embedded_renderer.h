// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A renderer that denoises in its own command buffers, frames that lie on the device.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <utility>

#include "gpu/device_test.h"
#include "gpu/embedded_frame.h"
#include "gpu/mirror_frames.h"
#include "gpu/put_on_device.h"
#include "stillray/vulkan.hpp"

namespace stillray::test {

class EmbeddedRenderer : public DeviceTest {
 protected:
  void TearDown() override {
    output_.reset();
    DeviceTest::TearDown();
  }
  VulkanContext context() const {
    return {instance_->handle(), device_->context().physical, device_->context().device,
            instance_->get_instance_proc_addr()};
  }
  static VulkanOptions Options(const Frame& f, DevicePrecision precision) {
    VulkanOptions options;
    options.width = f.width;
    options.height = f.height;
    options.precision = precision;
    options.virtual_guides = true;
    options.transmission = HasTransmission(f);
    return options;
  }
  void MakeOutput(const Frame& f) {
    output_ = std::make_unique<gpu::Arena>(&device_->context());
    colour_ = *output_->AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, f.width, f.height, 0);
    ASSERT_TRUE(output_->Allocate().ok());
    Run([&](VkCommandBuffer commands) {
      output_->RecordFirstUse(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                              VK_ACCESS_SHADER_WRITE_BIT);
      return Status::Ok();
    });
  }
  void Run(const std::function<Status(VkCommandBuffer)>& record) {
    const gpu::FairLock lock = device_->Lock();
    const Result<VkCommandBuffer> commands = device_->Begin();
    ASSERT_TRUE(commands.ok());
    const Status recorded = record(*commands);
    ASSERT_TRUE(recorded.ok()) << recorded.message();
    ASSERT_TRUE(device_->Run().ok());
  }

  VulkanFrame FrameOf(const Frame& f, const Frame& on_device) const {
    const gpu::DeviceFrame& pixels = *gpu::FrameOn(*device_, on_device);
    VulkanFrame out = EmbeddedFrame(f, pixels, [](const gpu::Image& image) {
      return VulkanImage{image.view, VK_IMAGE_LAYOUT_GENERAL};
    });
    out.colour = {colour_->view, VK_IMAGE_LAYOUT_GENERAL};
    return out;
  }

  Image3 Picture() {
    Image3 picture;
    std::array<Image1, 3> planes = PlanesOf<float, 3>(device_.get(), *colour_);
    for (size_t c = 0; c < 3; ++c) {
      picture.channel[c] = std::move(planes[c]);
    }
    return picture;
  }

  std::unique_ptr<gpu::Arena> output_;
  const gpu::Image* colour_ = nullptr;
};

}  // namespace stillray::test
