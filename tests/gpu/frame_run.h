// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames that go to a device, through what a test records, and back.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "denoise/vulkan/frame_upload.h"

namespace stillray::test {

inline std::unique_ptr<vulkan::FrameUpload> Upload(const gpu::DeviceContext& context,
                                                   const Frame& f) {
  auto made = vulkan::FrameUpload::Create(&context, f.width, f.height, vulkan::FactsOf(f));
  EXPECT_TRUE(made.ok()) << made.status().message();
  return std::move(made.value());
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
void RunFrame(gpu::Device* device, vulkan::FrameUpload* upload, const Frame& f, Image3* colour,
              const Record& record) {
  const gpu::DeviceContext& c = device->context();
  ASSERT_TRUE(upload->Write(f).ok());
  const Result<VkCommandBuffer> commands = device->Begin();
  ASSERT_TRUE(commands.ok());
  upload->Record(*commands);
  Barrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT);
  record(*commands);
  Barrier(c, *commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  upload->RecordDownload(*commands);
  Barrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
          VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
  const Status run = device->Run();
  ASSERT_TRUE(run.ok()) << run.message();
  ASSERT_TRUE(upload->ReadColour(colour).ok());
}

}  // namespace stillray::test
