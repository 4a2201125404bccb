// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/device_arrays.h"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

namespace stillray::render {
namespace {

/// Large arrays are uploaded in pieces.
constexpr size_t kPieceBytes = size_t{32} << 20;

}  // namespace

Status CheckArraySizes(const gpu::Device& device, std::span<const HostArray> arrays) {
  const uint32_t most = device.context().limits.maxStorageBufferRange;
  for (const HostArray& array : arrays) {
    if (array.bytes > most) {
      return Status::Unsupported(fmt::format(
          "{}: the scene has {:.1f} MiB of {}, but a storage buffer of the device holds {:.1f} MiB",
          device.info().name, static_cast<double>(array.bytes) * 0x1p-20, array.what,
          static_cast<double>(most) * 0x1p-20));
    }
  }
  return Status::Ok();
}

Status UploadArrays(gpu::Device* device, std::span<const HostArray> arrays,
                    std::span<const gpu::Buffer* const> buffers) {
  const gpu::DeviceContext& c = device->context();
  size_t largest = 1;
  for (const HostArray& array : arrays) {
    largest = std::max(largest, array.bytes);
  }
  const size_t piece_bytes = std::min(largest, kPieceBytes);
  gpu::Arena arena(&c);
  const Result<const gpu::Buffer*> piece =
      arena.AddBuffer(piece_bytes, 0, gpu::BufferPlace::kUpload);
  if (!piece.ok()) {
    return piece.status();
  }
  STILLRAY_RETURN_IF_ERROR(arena.Allocate());
  for (size_t i = 0; i < arrays.size(); ++i) {
    for (size_t done = 0; done < arrays[i].bytes; done += piece_bytes) {
      const size_t bytes = std::min(piece_bytes, arrays[i].bytes - done);
      std::memcpy((*piece)->mapped, static_cast<const char*>(arrays[i].data) + done, bytes);
      STILLRAY_RETURN_IF_ERROR(arena.Flush());
      const gpu::FairLock lock = device->Lock();
      const Result<VkCommandBuffer> commands = device->Begin();
      if (!commands.ok()) {
        return commands.status();
      }
      const VkBufferCopy region = {0, done, bytes};
      c.vk.CmdCopyBuffer(*commands, (*piece)->buffer, buffers[i]->buffer, 1, &region);
      gpu::MemoryBarrier(c, *commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                         c.shader_stages | VK_PIPELINE_STAGE_TRANSFER_BIT,
                         VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
      STILLRAY_RETURN_IF_ERROR(device->Run());
    }
  }
  return Status::Ok();
}

}  // namespace stillray::render
