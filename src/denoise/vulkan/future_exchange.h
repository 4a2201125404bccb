// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Transfers the histories of later frames between the device and host memory, which holds those of
/// many frames: see FutureLight.
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

  /// Transitions the images to their layout, once. Must be recorded before their first use.
  void Prepare(VkCommandBuffer commands);

  /// Copies to memory that the device reads. \param future  one history per signal, of this size
  Status Write(std::span<const SignalHistory> future);
  /// Records the copy to the images; the passes that read them must wait for it.
  void RecordUpload(VkCommandBuffer commands);

  /// Records the copy of the images to host memory, after the passes that write them.
  void RecordDownload(VkCommandBuffer commands);
  /// Must be called after the device has finished the download.
  Status Read(std::vector<SignalHistory>* future) const;

 private:
  explicit FutureExchange(const gpu::DeviceContext* context) : context_(context), arena_(context) {}
  /// First number of a signal's row in staging memory; which: 0 colour, 1 moments.
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
