// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Light of the future on its way between the device and memory of the host, where that of many
/// frames waits: see FutureLight.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "denoise/planes.h"
#include "denoise/vulkan/frame_images.h"

namespace stillray::vulkan {

class FutureExchange {
 public:
  static Result<std::unique_ptr<FutureExchange>> Create(const gpu::DeviceContext* context,
                                                        int width, int height, int signals);
  bool Fits(int width, int height, int signals) const {
    return width == width_ && height == height_ && signals == signals_;
  }
  const FutureImages& images() const { return images_; }
  gpu::MemoryUse memory() const { return arena_.Need(); }

  /// Brings the images to their layout, once. To be recorded before they are used.
  void Prepare(VkCommandBuffer commands);

  /// Copies into memory that the device sees. \param future  of every signal, of this size
  Status Write(std::span<const SignalHistory> future);
  /// Records the copy from there to the images; the passes that read them must wait for it.
  void RecordUpload(VkCommandBuffer commands);

  /// Records the copy of the images, once passes have written them, to memory that the host sees.
  void RecordDownload(VkCommandBuffer commands);
  /// To be called when the device has run that.
  Status Read(std::vector<SignalHistory>* future) const;

 private:
  explicit FutureExchange(const gpu::DeviceContext* context) : context_(context), arena_(context) {}
  /// First number of a signal's row in the staging memory; which: 0 light, 1 moments.
  float* Row(int which, int signal, int y) const;

  const gpu::DeviceContext* context_;
  gpu::Arena arena_;
  int width_ = 0;
  int height_ = 0;
  int signals_ = 0;
  FutureImages images_;
  const gpu::Buffer* staging_ = nullptr;
  bool prepared_ = false;
};

}  // namespace stillray::vulkan
