// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Recording compute passes into a command buffer.
#pragma once

#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

#include "denoise/vulkan/frame_images.h"
#include "gpu/timestamps.h"

namespace stillray::vulkan {

/// An image of the caller's as shaders see it.
struct ImageRef {
  VkImageView view = VK_NULL_HANDLE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;
};

/// All that a frame brings and takes; images that are not given have no view.
struct FrameInputs {
  ImageRef lights[6];          ///< by SignalKind
  ImageRef second_moments[6];  ///< likewise
  ImageRef depth;
  ImageRef normal;
  ImageRef id;
  ImageRef motion;
  ImageRef albedos[3];  ///< albedo, specular albedo, transmission albedo
  ImageRef emission;
  ImageRef background;
  ImageRef samples;
  ImageRef roughness;
  ImageRef colour;              ///< output: R32G32B32A32_SFLOAT, or R16G16B16A16_SFLOAT ...
  bool colour_is_half = false;  ///< ... as this says
  ImageRef display;             ///< output: R8G8B8A8_UNORM
};

/// Passes over a frame in one command buffer. The first error is kept; what follows it is skipped.
class PassRecorder {
 public:
  PassRecorder(const gpu::DeviceContext* context, Pipelines* pipelines, gpu::DescriptorSets* sets,
               gpu::Timestamps* times, VkCommandBuffer commands)
      : context_(context), pipelines_(pipelines), sets_(sets), times_(times), commands_(commands) {}

  /// Chooses set 0 for what follows.
  void UseFrame(const FrameInputs& inputs, const FrameImages& images);

  /// Buffers for the shaders that have some of their own, which take as many as they ask for.
  void UseBuffers(std::initializer_list<const gpu::Buffer*> buffers) {
    buffers_.assign(buffers.begin(), buffers.end());
  }

  /// What was written before is read by what follows.
  void Barrier();

  /// A barrier, then one pass.
  /// \param images  what the shader reads, then what it writes
  template <typename Push>
  void Run(Shader shader, Groups groups, std::initializer_list<const gpu::Image*> images,
           const Push& push, std::span<const uint32_t> constants = {}) {
    RunBytes(shader, groups, {images.begin(), images.size()}, &push, constants);
  }
  void Run(Shader shader, Groups groups, std::initializer_list<const gpu::Image*> images) {
    RunBytes(shader, groups, {images.begin(), images.size()}, nullptr, {});
  }

  /// Ends the time of the last pass.
  void EndTimes();

  VkCommandBuffer commands() const { return commands_; }
  const Status& status() const { return status_; }

 private:
  void RunBytes(Shader shader, Groups groups, std::span<const gpu::Image* const> images,
                const void* push, std::span<const uint32_t> constants);

  const gpu::DeviceContext* context_;
  Pipelines* pipelines_;
  gpu::DescriptorSets* sets_;
  gpu::Timestamps* times_;
  VkCommandBuffer commands_;
  VkDescriptorSet frame_set_ = VK_NULL_HANDLE;
  std::vector<const gpu::Buffer*> buffers_;
  std::string_view part_;
  Status status_;
};

}  // namespace stillray::vulkan
