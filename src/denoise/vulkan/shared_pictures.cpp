// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "denoise/vulkan/shared_pictures.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include <fmt/format.h>

namespace stillray::vulkan {
namespace {

// The viewer holds at most six: three frames between its threads, the last one, two being drawn.
constexpr size_t kMostPictures = 8;

}  // namespace

Result<std::shared_ptr<DevicePicture>> DevicePicture::Create(std::shared_ptr<gpu::Device> device,
                                                             int width, int height) {
  std::shared_ptr<DevicePicture> made(new DevicePicture(std::move(device), width, height));
  const VkDeviceSize bytes =
      VkDeviceSize{4} * static_cast<VkDeviceSize>(width) * static_cast<VkDeviceSize>(height);
  Result<std::unique_ptr<gpu::SharedBuffer>> buffer =
      gpu::SharedBuffer::Create(&made->device_->context(), bytes);
  STILLRAY_RETURN_IF_ERROR(buffer.status());
  made->buffer_ = std::move(buffer.value());
  return made;
}

Result<std::shared_ptr<DevicePicture>> SharedPictures::Take(int width, int height) {
  std::erase_if(pictures_, [&](const std::shared_ptr<DevicePicture>& picture) {
    return picture->width() != width || picture->height() != height;
  });
  for (const std::shared_ptr<DevicePicture>& picture : pictures_) {
    if (picture.use_count() == 1) {
      // Orders the accesses of the last holder, on its thread, before those of this thread.
      std::atomic_thread_fence(std::memory_order_acquire);
      return picture;
    }
  }
  if (pictures_.size() == kMostPictures) {
    return Status::OutOfMemory(fmt::format("all of {} shared pictures are held", kMostPictures));
  }
  Result<std::shared_ptr<DevicePicture>> made = DevicePicture::Create(device_, width, height);
  STILLRAY_RETURN_IF_ERROR(made.status());
  pictures_.push_back(*made);
  return made;
}

gpu::MemoryUse SharedPictures::memory() const {
  gpu::MemoryUse sum;
  for (const std::shared_ptr<DevicePicture>& picture : pictures_) {
    sum += {1, 1, picture->memory_bytes(), picture->memory_bytes()};
  }
  return sum;
}

}  // namespace stillray::vulkan
