// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Downloads finished images from the device to the host.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "denoise/vulkan/pass_recorder.h"
#include "gpu/memory.h"
#include "stillray/denoise.hpp"

namespace stillray::vulkan {

/// An output image of a frame, and host memory for its download, allocated on first use.
class OutputImage {
 public:
  /// \param texel_bytes  of the format
  OutputImage(const gpu::DeviceContext* context, VkFormat format, int texel_bytes)
      : context_(context), format_(format), texel_bytes_(texel_bytes) {}

  /// Creates the image. On failure nothing stays allocated.
  Status Make(int width, int height);
  /// Allocates the host memory, unless it exists. On failure nothing stays allocated.
  Status PrepareCopy();
  /// Must be called before a shader writes the image.
  void RecordUse(VkCommandBuffer commands);
  void RecordCopy(VkCommandBuffer commands) const { RecordCopyTo(host_->buffer, commands); }
  void RecordCopyTo(VkBuffer buffer, VkCommandBuffer commands) const;
  /// The rows of the image, tightly packed, once the copy has finished.
  Result<const void*> Texels() const;

  bool is_made() const { return image_ != nullptr; }
  ImageRef ref() const { return {is_made() ? image_->view : VK_NULL_HANDLE, kLayout}; }
  gpu::MemoryUse memory() const;

 private:
  static constexpr VkImageLayout kLayout = VK_IMAGE_LAYOUT_GENERAL;

  const gpu::DeviceContext* context_;
  VkFormat format_;
  int texel_bytes_;
  std::unique_ptr<gpu::Arena> image_memory_;
  std::unique_ptr<gpu::Arena> host_memory_;
  const gpu::Image* image_ = nullptr;
  const gpu::Buffer* host_ = nullptr;
  bool used_ = false;
};

/// The results of frames of one size: the colour, and the displayed image if requested.
class FrameDownload {
 public:
  static Result<std::unique_ptr<FrameDownload>> Create(const gpu::DeviceContext* context, int width,
                                                       int height);
  bool Fits(int width, int height) const { return width == width_ && height == height_; }

  /// Allocates memory for these results; existing memory is kept.
  Status Prepare(const Results& wanted);
  /// Records the use of the prepared results; must be called before the frame is recorded.
  void RecordUse(VkCommandBuffer commands);
  /// Adds the images to the inputs of the frame.
  void ShowTo(FrameInputs* images) const;
  /// Records the copies, once the writes are visible to transfers.
  void Record(VkCommandBuffer commands, const Results& wanted) const;
  /// Records the copies to shared memory, and its release to other APIs.
  void RecordShared(VkCommandBuffer commands, uint32_t queue_family,
                    const gpu::SharedBuffer& buffer) const;
  /// The finished colour on the device.
  ImageRef picture() const { return colour_.ref(); }
  Status ReadColour(Image3* colour) const;
  /// Reads the colour's alpha: see FrameFacts::keeps_length.
  Status ReadLength(Image1* length) const;
  /// Reads the results into `out`; clears those that are not requested.
  Status Read(const Results& wanted, DenoisedFrame* out) const;

  gpu::MemoryUse memory() const;

 private:
  FrameDownload(const gpu::DeviceContext* context, int width, int height)
      : context_(context),
        width_(width),
        height_(height),
        colour_(context, VK_FORMAT_R32G32B32A32_SFLOAT, 16),
        display_(context, VK_FORMAT_R8G8B8A8_UNORM, 4) {}

  const gpu::DeviceContext* context_;
  int width_;
  int height_;
  OutputImage colour_;
  OutputImage display_;
};

}  // namespace stillray::vulkan
