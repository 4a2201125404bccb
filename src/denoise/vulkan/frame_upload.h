// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Uploads frames from the host to the device.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "denoise/backend.h"
#include "denoise/vulkan/parameters.h"
#include "denoise/vulkan/pass_recorder.h"
#include "gpu/device.h"
#include "stillray/frame.h"

namespace stillray::vulkan {

/// Device images for all images of a frame, and their staging memory.
class FrameUpload {
 public:
  /// \param facts  the images that exist
  static Result<std::unique_ptr<FrameUpload>> Create(const gpu::DeviceContext* context, int width,
                                                     int height, const FrameFacts& facts);
  /// Whether a frame has the images of this upload, in number and size.
  bool Fits(int width, int height, const FrameFacts& facts) const;

  /// Copies the frame to staging memory.
  /// \param images  stored in the fourth channels of the specular albedo and of the emission
  Status Write(const Frame& frame, const ShownImages& images = {});
  /// Records the copies to the images.
  void Record(VkCommandBuffer commands);

  const FrameInputs& inputs() const { return inputs_; }
  gpu::MemoryUse memory() const { return arena_.Need(); }

 private:
  struct Entry {
    const gpu::Image* image = nullptr;
    VkDeviceSize offset = 0;
    int channels = 0;  ///< of 32 bits each
  };

  explicit FrameUpload(const gpu::DeviceContext* context) : context_(context), arena_(context) {}
  Status Add(VkFormat format, int channels, Entry* entry, ImageRef* input);
  template <int N>
  void WritePlanes(const Entry& entry, const Planes<float, N>& planes);
  void WriteFourth(const Entry& entry, const Image1& plane);
  template <typename T>
  void WritePlane(const Entry& entry, const Plane<T>& plane);

  const gpu::DeviceContext* context_;
  int width_ = 0;
  int height_ = 0;
  FrameFacts facts_;
  gpu::Arena arena_;
  FrameInputs inputs_;
  VkDeviceSize staged_ = 0;
  const gpu::Buffer* staging_ = nullptr;
  bool prepared_ = false;

  Entry lights_[6];
  Entry second_moments_[6];
  Entry depth_;
  Entry normal_;
  Entry id_;
  Entry motion_;
  Entry albedos_[3];
  Entry emission_;
  Entry background_;
  Entry samples_;
  Entry roughness_;
  Entry confidence_;
  Entry previous_normal_;
};

}  // namespace stillray::vulkan
