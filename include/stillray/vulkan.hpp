// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser within a renderer's own Vulkan frame: the renderer's device, its images, its
/// command buffer. Recording submits nothing, waits for nothing, and allocates nothing once the
/// images of the frame have come round to those seen before. docs/gpu.md says more.
///
/// What the device must offer, and have enabled: Vulkan 1.1 and the feature
/// shaderStorageImageExtendedFormats. The queue must do compute.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

/// The renderer's device. All must outlive the denoiser.
struct VulkanContext {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;
};

struct VulkanOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  bool transmission = false;  ///< frames have transmission signals
  DevicePrecision precision = DevicePrecision::kHalf;
  bool timestamps = false;  ///< measure the stages; the queue must have timestamps
  /// Frames may know their guides only where a path was traced: pixels with depth 0 and no sample
  /// are completed on the device (docs/denoiser.md, fill_guides) with any of the images below,
  /// which takes memory. `samples` and `motion` must be given then.
  bool incomplete_guides = false;
};

/// A plain 2D image (VK_IMAGE_VIEW_TYPE_2D) of the denoiser's size; no view: not given. Usage:
/// SAMPLED for inputs, STORAGE for outputs. Inputs may have any layout that shaders may read from,
/// outputs must be in VK_IMAGE_LAYOUT_GENERAL.
struct VulkanImage {
  VkImageView view = VK_NULL_HANDLE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;
};

/// Images of one frame, by the conventions of Frame and Guides. Inputs may have any format that
/// shaders read as float (`id`: R32_UINT), and any number of channels from the one needed on.
struct VulkanFrame {
  int64_t index = 0;
  /// Mean of this frame's samples per pixel. Below 1 the filter takes what is missing for missing,
  /// and feeds back only whole samples; above 1 nothing changes.
  float samples_per_pixel = 1;
  /// See Frame::jitter_x.
  float jitter_x = 0;
  float jitter_y = 0;

  VulkanImage lights[kSignalKindCount];          ///< by SignalKind: r, g, b
  VulkanImage second_moments[kSignalKindCount];  ///< see Signal::second_moment
  VulkanImage depth;                             ///< of every pixel, unless `incomplete_guides`
  VulkanImage normal;                            ///< x, y, z
  VulkanImage id;
  VulkanImage motion;  ///< x, y
  VulkanImage albedo;
  VulkanImage specular_albedo;
  VulkanImage transmission_albedo;
  VulkanImage emission;
  VulkanImage background;
  VulkanImage samples;
  VulkanImage roughness;

  /// The result: scene-linear, R32G32B32A32_SFLOAT, or R16G16B16A16_SFLOAT if `colour_is_half`.
  VulkanImage colour;
  bool colour_is_half = false;
  /// The same with exposure, tone curve and sRGB encoding, R8G8B8A8_UNORM; need not be given.
  VulkanImage display;
};

/// Denoises a sequence frame by frame. One object holds one sequence's history; it must not be used
/// by two threads at once.
class VulkanDenoiser {
 public:
  /// What Create allocates: images, buffers and their memory on the device. Allocates nothing.
  static Result<DeviceMemory> MemoryNeed(const VulkanContext& context,
                                         const VulkanOptions& options);
  /// Makes all images, buffers and pipelines.
  /// \return kInvalidArgument, kUnsupported (the device lacks something, by name), kOutOfMemory
  static Result<VulkanDenoiser> Create(const VulkanContext& context, const VulkanOptions& options);
  VulkanDenoiser(VulkanDenoiser&&) noexcept;
  VulkanDenoiser& operator=(VulkanDenoiser&&) noexcept;
  /// The device must have done with all that was recorded.
  ~VulkanDenoiser();

  /// Records the next frame, outside of a render pass. Command buffers are to be submitted once
  /// each and in the order of recording, to one queue.
  ///
  /// Before: the inputs' writes must be visible to VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
  /// VK_ACCESS_SHADER_READ_BIT, and earlier readers of the outputs must be through. Between frames
  /// and stages the denoiser sets barriers of its own. After: the outputs were written by
  /// VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT, and stay in their layout;
  /// inputs may be written again after VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT.
  /// \return kInvalidArgument naming the image that is missing; nothing was recorded then
  Status Record(VkCommandBuffer commands, const VulkanFrame& frame);

  /// New settings from the next frame on; compiles shaders where they ask for others.
  /// \return kInvalidArgument if they are not valid or need other images: `signals`,
  ///         `limit_history`, `feedback`, `firefly` and `wavelet` may
  Status SetSettings(const Settings& settings);
  const Settings& settings() const;
  /// The next frame is a first frame.
  void Reset();
  /// To be called before views that were given are destroyed, when the device has done with them.
  Status ForgetImages();

  DeviceMemory memory() const;
  /// Of the last recorded frame, once the device has run it; empty before that or without
  /// `timestamps`.
  std::vector<StageTime> timings() const;

 private:
  struct Impl;
  explicit VulkanDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillray
