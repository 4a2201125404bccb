// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A frame in the image formats of a real-time renderer: radiance and normals as halves, albedos in
/// 8 bits, motion as two halves, depth and id in 32 bits; the result as halves.
#pragma once

#include <memory>
#include <vector>

#include "denoise/vulkan/frame_download.h"
#include "denoise/vulkan/pass_recorder.h"
#include "stillray/frame.h"

namespace stillray::vulkan {

class PackedInputs {
 public:
  /// \param frame  must have depth, normal, albedo, specular albedo, motion and id, and no other
  ///     guides
  static Result<std::unique_ptr<PackedInputs>> Create(const gpu::DeviceContext* context,
                                                      const Frame& frame);
  /// Records the copy of the frame to the images, and prepares the result image; call once.
  void Record(VkCommandBuffer commands);

  const FrameInputs& inputs() const { return inputs_; }

 private:
  struct Entry {
    const gpu::Image* image = nullptr;
    VkDeviceSize offset = 0;
    std::vector<uint32_t> words;  ///< the texels
    ImageRef* input = nullptr;
  };
  explicit PackedInputs(const gpu::DeviceContext* context)
      : context_(context), arena_(context), colour_(context, VK_FORMAT_R16G16B16A16_SFLOAT, 8) {}
  Status Add(VkFormat format, std::vector<uint32_t> words, ImageRef* input);
  Status AddAll(const Frame& frame);
  Status Stage();

  const gpu::DeviceContext* context_;
  gpu::Arena arena_;
  OutputImage colour_;
  FrameInputs inputs_;
  int width_ = 0;
  int height_ = 0;
  VkDeviceSize staged_ = 0;
  const gpu::Buffer* staging_ = nullptr;
  std::vector<Entry> entries_;
};

}  // namespace stillray::vulkan
