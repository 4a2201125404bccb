// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Shared memory as another device sees it, as OpenGL would.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <vector>

#include "gpu/memory.h"

namespace stillray::test {

/// The first bytes of exported memory, read through a device that imports it.
/// \param descriptor    given away
/// \param memory_bytes  of the memory
inline std::vector<uint8_t> ImportedBytes(gpu::Device* device, int descriptor,
                                          VkDeviceSize memory_bytes, VkDeviceSize wanted) {
  const gpu::DeviceContext& c = device->context();
  VkExternalMemoryBufferCreateInfo external = {};
  external.sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO;
  external.handleTypes = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  VkBufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.pNext = &external;
  info.size = wanted;
  info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  VkBuffer buffer = VK_NULL_HANDLE;
  EXPECT_EQ(c.vk.CreateBuffer(c.device, &info, nullptr, &buffer), VK_SUCCESS);
  VkMemoryRequirements need = {};
  c.vk.GetBufferMemoryRequirements(c.device, buffer, &need);
  VkImportMemoryFdInfoKHR import = {};
  import.sType = VK_STRUCTURE_TYPE_IMPORT_MEMORY_FD_INFO_KHR;
  import.handleType = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
  import.fd = descriptor;
  VkMemoryAllocateInfo allocate = {};
  allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  allocate.pNext = &import;
  allocate.allocationSize = memory_bytes;
  while ((need.memoryTypeBits >> allocate.memoryTypeIndex & 1u) == 0) {
    ++allocate.memoryTypeIndex;
  }
  VkDeviceMemory memory = VK_NULL_HANDLE;
  std::vector<uint8_t> bytes(wanted);
  const VkResult imported = c.vk.AllocateMemory(c.device, &allocate, nullptr, &memory);
  EXPECT_EQ(imported, VK_SUCCESS);
  if (imported != VK_SUCCESS) {
    close(descriptor);
  } else {
    EXPECT_EQ(c.vk.BindBufferMemory(c.device, buffer, memory, 0), VK_SUCCESS);
    gpu::Arena arena(&c);
    const gpu::Buffer* down = *arena.AddBuffer(wanted, 0, gpu::BufferPlace::kDownload);
    EXPECT_TRUE(arena.Allocate().ok());
    const VkCommandBuffer commands = *device->Begin();
    const VkBufferCopy region = {0, 0, wanted};
    c.vk.CmdCopyBuffer(commands, buffer, down->buffer, 1, &region);
    gpu::MemoryBarrier(c, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                       VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT);
    EXPECT_TRUE(device->Run().ok());
    EXPECT_TRUE(arena.Invalidate().ok());
    std::memcpy(bytes.data(), down->mapped, wanted);
  }
  c.vk.DestroyBuffer(c.device, buffer, nullptr);
  c.vk.FreeMemory(c.device, memory, nullptr);
  return bytes;
}

}  // namespace stillray::test
