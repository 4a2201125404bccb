// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The compute passes of a frame, as commands.
#pragma once

#include <initializer_list>
#include <span>
#include <string_view>
#include <vector>

#include "denoise/signal_groups.h"
#include "denoise/vulkan/frame_images.h"
#include "gpu/command_list.h"
#include "gpu/timestamps.h"

namespace stillray::vulkan {

/// A caller's image, as shaders use it.
struct ImageRef {
  VkImageView view = VK_NULL_HANDLE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;
};

/// All inputs and outputs of a frame; absent images have no view.
struct FrameInputs {
  ImageRef lights[6];          ///< by SignalKind
  ImageRef second_moments[6];  ///< by SignalKind
  ImageRef depth;
  ImageRef normal;
  ImageRef id;
  ImageRef motion;
  ImageRef albedos[3];  ///< albedo, specular albedo, transmission albedo
  ImageRef emission;
  ImageRef background;
  ImageRef samples;
  ImageRef roughness;
  ImageRef confidence;
  ImageRef previous_normal;
  ImageRef colour;              ///< output: R32G32B32A32_SFLOAT
  bool colour_is_half = false;  ///< `colour` is R16G16B16A16_SFLOAT instead
  ImageRef display;             ///< output: R8G8B8A8_UNORM
  /// Outputs in the format of `colour`: the filtered, demodulated signals.
  ImageRef filtered[kMostGroups];
};

/// Passes over a frame. After the first error, which is kept, no more are added.
class PassRecorder {
 public:
  /// \param times  receives the times of the frame; nullptr: not measured
  PassRecorder(Pipelines* pipelines, gpu::DescriptorSets* sets, gpu::Timestamps* times,
               gpu::CommandList* commands)
      : pipelines_(pipelines), sets_(sets), times_(times), commands_(commands) {}

  /// Chooses set 0 for the following passes.
  void UseFrame(const FrameInputs& inputs, const FrameImages& images);

  /// Sets the storage buffers of the following passes; each binds the first ShaderInfo::buffers of
  /// them.
  void UseBuffers(std::initializer_list<const gpu::Buffer*> buffers) {
    buffers_.assign(buffers.begin(), buffers.end());
  }

  /// For commands other than passes: a barrier before them, and one before the next pass.
  void Barrier();

  /// Adds one pass, after a barrier if it depends on a pass since the last barrier (read after
  /// write, write after read, or write after write).
  /// \param images  first the images that the shader reads, then those that it writes
  template <typename Push>
  void Run(Shader shader, Groups groups, std::initializer_list<const gpu::Image*> images,
           const Push& push, std::span<const uint32_t> constants = {}) {
    RunBytes(shader, groups, {images.begin(), images.size()}, &push, constants);
  }
  void Run(Shader shader, Groups groups, std::initializer_list<const gpu::Image*> images) {
    RunBytes(shader, groups, {images.begin(), images.size()}, nullptr, {});
  }

  /// Assigns the time of the next pass to this part, not to the stage of its shader.
  /// \param part  of static storage
  void CountAs(std::string_view part) { next_part_ = part; }

  /// Ends the part of the last pass.
  void EndParts();

  /// Bytes of the denoiser's own images that the passes read and write; each image counts once per
  /// pass.
  uint64_t bytes() const { return bytes_; }
  gpu::CommandList* commands() const { return commands_; }
  const Status& status() const { return status_; }

 private:
  void EmitBarrier();
  /// Whether the pass must wait for another one since the last barrier.
  bool Waits(const ShaderInfo& info, std::span<const gpu::Image* const> images) const;
  void NoteUses(const ShaderInfo& info, std::span<const gpu::Image* const> images);
  void RunBytes(Shader shader, Groups groups, std::span<const gpu::Image* const> images,
                const void* push, std::span<const uint32_t> constants);

  Pipelines* pipelines_;
  gpu::DescriptorSets* sets_;
  gpu::Timestamps* times_;
  gpu::CommandList* commands_;
  VkDescriptorSet frame_set_ = VK_NULL_HANDLE;
  std::vector<const gpu::Buffer*> buffers_;
  bool always_waits_ = true;  // the next pass waits for commands other than passes
  // Since the last barrier: images and buffers.
  std::vector<const void*> read_;
  std::vector<const void*> written_;
  uint64_t bytes_ = 0;
  std::string_view part_;
  std::string_view next_part_;
  Status status_;
};

}  // namespace stillray::vulkan
