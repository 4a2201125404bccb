// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Finished images in memory that other APIs can import.
#pragma once

#include <memory>
#include <vector>

#include "gpu/device.h"
#include "gpu/memory.h"
#include "stillray/shared_picture.h"

namespace stillray::vulkan {

class DevicePicture : public SharedPicture {
 public:
  static Result<std::shared_ptr<DevicePicture>> Create(std::shared_ptr<gpu::Device> device,
                                                       int width, int height);

  int width() const override { return width_; }
  int height() const override { return height_; }
  uint64_t memory_bytes() const override { return buffer_->memory_bytes(); }
  Uuid device_uuid() const override { return device_->context().sharing.device; }
  Uuid driver_uuid() const override { return device_->context().sharing.driver; }
  Result<int> Export() const override { return buffer_->Export(); }

  const gpu::SharedBuffer& buffer() const { return *buffer_; }

 private:
  DevicePicture(std::shared_ptr<gpu::Device> device, int width, int height)
      : device_(std::move(device)), width_(width), height_(height) {}

  std::shared_ptr<gpu::Device> device_;
  int width_;
  int height_;
  std::unique_ptr<gpu::SharedBuffer> buffer_;  // destroyed first, since it belongs to the device
};

/// A pool of images of one size, which grows to the number held at a time.
class SharedPictures {
 public:
  explicit SharedPictures(std::shared_ptr<gpu::Device> device) : device_(std::move(device)) {}

  /// An image that is not held elsewhere, for writing.
  /// \return kUnsupported: the device shares no memory; kOutOfMemory, also if very many are held
  Result<std::shared_ptr<DevicePicture>> Take(int width, int height);
  gpu::MemoryUse memory() const;

 private:
  std::shared_ptr<gpu::Device> device_;
  std::vector<std::shared_ptr<DevicePicture>> pictures_;
};

}  // namespace stillray::vulkan
