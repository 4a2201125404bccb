// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Runs frames through commands that a test records on a device.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "denoise/vulkan/frame_download.h"
#include "denoise/vulkan/frame_upload.h"

namespace stillray::test {

/// Images on the device for a frame and its picture.
struct FrameOnDevice {
  std::unique_ptr<vulkan::FrameUpload> upload;
  std::unique_ptr<vulkan::FrameDownload> download;

  vulkan::FrameInputs inputs() const {
    vulkan::FrameInputs images = upload->inputs();
    download->ShowTo(&images);
    return images;
  }
};

inline std::unique_ptr<FrameOnDevice> Upload(const gpu::DeviceContext& context, const Frame& f) {
  auto upload = vulkan::FrameUpload::Create(&context, f.width, f.height, FactsOf(f));
  EXPECT_TRUE(upload.ok()) << upload.status().message();
  auto download = vulkan::FrameDownload::Create(&context, f.width, f.height);
  EXPECT_TRUE(download.ok() && (*download)->Prepare(Results()).ok());
  return std::unique_ptr<FrameOnDevice>(
      new FrameOnDevice{std::move(upload.value()), std::move(download.value())});
}

inline void Barrier(const gpu::DeviceContext& c, VkCommandBuffer commands,
                    VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
                    VkAccessFlags read) {
  VkMemoryBarrier memory = {};
  memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  memory.srcAccessMask = written;
  memory.dstAccessMask = read;
  c.vk.CmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

/// Copies the frame to the device, lets `record` record, and reads the picture back.
template <typename Record>
void RunFrame(gpu::Device* device, FrameOnDevice* on_device, const Frame& f, Image3* colour,
              const Record& record) {
  const gpu::DeviceContext& c = device->context();
  ASSERT_TRUE(on_device->upload->Write(f).ok());
  const Result<VkCommandBuffer> commands = device->Begin();
  ASSERT_TRUE(commands.ok());
  on_device->upload->Record(*commands);
  on_device->download->RecordUse(*commands);
  Barrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT);
  record(*commands);
  Barrier(c, *commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  on_device->download->Record(*commands, Results());
  Barrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
  const Status run = device->Run();
  ASSERT_TRUE(run.ok()) << run.message();
  ASSERT_TRUE(on_device->download->ReadColour(colour).ok());
}

}  // namespace stillray::test
