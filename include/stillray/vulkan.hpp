// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser within a renderer's own Vulkan frame: on the renderer's device, images and command
/// buffer. Recording submits nothing, waits for nothing, and allocates no memory of the device. See
/// docs/gpu.md.
///
/// The device must support, and have enabled, Vulkan 1.1 and the feature
/// shaderStorageImageExtendedFormats. The queue must support compute.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "stillray/camera.h"
#include "stillray/denoise.hpp"

namespace stillray {

class VulkanDenoiser;

/// The largest number of signals; see VulkanFrame::filtered.
inline constexpr int kVulkanSignals = 4;

/// A part of the renderer's device memory.
struct VulkanMemoryBlock {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;  ///< in bytes, a multiple of the requested alignment
  void* handle = nullptr;   ///< the allocator's own
};

/// The renderer's allocator of device memory. Without one, the denoiser calls vkAllocateMemory.
struct VulkanAllocator {
  void* user = nullptr;
  /// Called by VulkanDenoiser::Create for each block of images and buffers. `need` has the bytes,
  /// the alignment (bufferImageGranularity included), and one memory type, as a bit. The memory is
  /// not mapped.
  /// \return VK_SUCCESS, or what went wrong
  VkResult (*allocate)(void* user, const VkMemoryRequirements* need,
                       VulkanMemoryBlock* block) = nullptr;
  /// Called by the denoiser's destructor, and by Create after a failure.
  void (*free)(void* user, const VulkanMemoryBlock* block) = nullptr;
};

/// The renderer's device. All must outlive the denoiser.
struct VulkanContext {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;
  /// The renderer's cache, in which pipelines are looked up and kept; optional.
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  VulkanAllocator allocator = {};  ///< both functions, or none
};

struct VulkanOptions {
  Settings settings;
  int width = 0;
  int height = 0;
  bool transmission = false;  ///< frames have transmission signals
  DevicePrecision precision = DevicePrecision::kHalf;
  bool timestamps = false;  ///< measure the stages; the queue must support timestamps
  /// Guides may be known only where a path was traced: pixels with depth 0 and no sample are filled
  /// on the device (docs/denoiser.md, fill_guides), together with the images below, which takes
  /// memory. `samples` and `motion` must be given then.
  bool incomplete_guides = false;
  /// Frames have virtual guides: reflected light, and with `transmission` transmitted light too,
  /// are denoised by them, each in a filter of its own, which takes memory and time (docs/gpu.md).
  /// They are as long as the setting `virtual_roughness` is above 0 and `signals` keeps these
  /// lights apart (`split` or `diffuse_specular`).
  bool virtual_guides = false;
  /// Frames may have hit distances in place of depth and motion of `reflection`, which takes 12
  /// bytes per pixel more. Needs `virtual_guides`.
  bool hit_distances = false;
  /// 0: the images of frames are a few that come again; descriptor sets are kept by their views, so
  /// that views must live until ForgetImages. Above 0: every frame may have other views, which must
  /// live until the device has finished the frame. Record then rewrites the sets of the frame that
  /// was recorded this many frames ago, which the device must have finished. At most 64.
  int frames_in_flight = 0;
  /// Marks the stages in the command buffer, for debuggers. The instance must have
  /// VK_EXT_debug_utils enabled.
  bool debug_labels = false;
  /// A denoiser on the same device whose pipelines this one uses too, so that they are compiled
  /// once. Read by Create only; either may be destroyed first.
  const VulkanDenoiser* share_with = nullptr;
};

/// A plain 2D image (VK_IMAGE_VIEW_TYPE_2D) of at least the frame's size; no view: not given.
/// Usage: SAMPLED for inputs, STORAGE for outputs. Inputs may have any layout that shaders may read
/// from, outputs must be in VK_IMAGE_LAYOUT_GENERAL.
struct VulkanImage {
  VkImageView view = VK_NULL_HANDLE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;
};

/// What is seen in smooth surfaces, or through them: see VirtualGuides. Given as a whole (`id` with
/// VulkanFrame::id) or not at all.
struct VulkanVirtualGuides {
  VulkanImage depth;
  VulkanImage normal;
  VulkanImage motion;
  VulkanImage id;
  VulkanImage albedo;
};

/// Images of one frame, by the conventions of Frame and Guides. Inputs may have any format that
/// shaders read as float (`id`: R32_UINT), with at least the required number of channels.
struct VulkanFrame {
  int64_t index = 0;
  /// Mean of this frame's samples per pixel. Below 1 the filter treats pixels without a sample as
  /// missing, and feeds back only whole samples; values above 1 have no effect.
  float samples_per_pixel = 1;
  /// See Frame::jitter_x.
  float jitter_x = 0;
  float jitter_y = 0;
  float focal_pixels = 0;  ///< see Frame::focal_pixels
  /// In pixels, at most those of the options; 0: those of the options. Images may be larger: the
  /// frame is in their corner (0, 0). After another size the history is resampled.
  int width = 0;
  int height = 0;

  VulkanImage lights[kSignalKindCount];  ///< by SignalKind: r, g, b
  /// See Signal::second_moment. They are not estimated: without them frames of several samples per
  /// pixel are hardly filtered.
  VulkanImage second_moments[kSignalKindCount];
  VulkanImage depth;   ///< of every pixel, unless `incomplete_guides`
  VulkanImage normal;  ///< x, y, z
  VulkanImage id;
  VulkanImage motion;  ///< x, y
  VulkanImage albedo;
  VulkanImage specular_albedo;
  VulkanImage transmission_albedo;
  VulkanImage emission;
  VulkanImage background;
  VulkanImage samples;
  VulkanImage roughness;
  VulkanImage confidence;       ///< see Frame::confidence
  VulkanImage previous_normal;  ///< see Guides::previous_normal
  /// Of reflected light, with VulkanOptions::virtual_guides. `roughness`, `motion`, `albedo` and
  /// `specular_albedo` must be given too. A frame without them begins a new history.
  VulkanVirtualGuides reflection;
  /// With VulkanOptions::hit_distances, in place of `reflection.depth` and `reflection.motion`,
  /// which follow from it and from the cameras (ReflectionsFromHits): length of the reflected ray
  /// from the first surface, in the unit of depth. >= 1e9 and infinity: the sky; 0, negative, NaN:
  /// no image. The other images of `reflection` may lack then: normal and id are those of the
  /// mirror, and the albedo of what is seen is white.
  VulkanImage hit_distance;
  /// Perspective cameras of this frame and of the one before it, without jitter; of the first frame
  /// the same twice. Read with `hit_distance`.
  CameraMatrices camera = {};
  CameraMatrices previous_camera = {};
  /// Of transmitted light, if VulkanOptions::transmission is set as well; likewise, with
  /// `transmission_albedo` in place of `specular_albedo`.
  VulkanVirtualGuides refraction;

  /// The result: scene-linear, R32G32B32A32_SFLOAT, or R16G16B16A16_SFLOAT if `colour_is_half`.
  VulkanImage colour;
  bool colour_is_half = false;
  /// The same with exposure, tone curve and sRGB encoding, R8G8B8A8_UNORM; optional.
  VulkanImage display;
  /// The filtered light of signals, divided by their albedos (by 0.01 where those are less), before
  /// antialiasing and without emission, in the format of `colour`; optional. By signal of the
  /// setting `signals`, in this order: `split` direct diffuse, indirect diffuse, specular,
  /// transmission; `diffuse_specular` diffuse, specular, transmission; `direct_indirect` direct,
  /// indirect (divided by the sum of all albedos, as `single`); `single` one; `channels` red,
  /// green, blue. Not of light with virtual guides, which is divided by what is seen.
  VulkanImage filtered[kVulkanSignals];
};

/// Denoises a sequence frame by frame. One object holds the history of one sequence; it must not be
/// used by two threads at once.
class VulkanDenoiser {
 public:
  /// The images, buffers and device memory that Create allocates. Allocates nothing.
  static Result<DeviceMemory> MemoryNeed(const VulkanContext& context,
                                         const VulkanOptions& options);
  /// Creates all images, buffers and pipelines.
  /// \return kInvalidArgument, kUnsupported (naming the missing feature), kOutOfMemory
  static Result<VulkanDenoiser> Create(const VulkanContext& context, const VulkanOptions& options);
  VulkanDenoiser(VulkanDenoiser&&) noexcept;
  VulkanDenoiser& operator=(VulkanDenoiser&&) noexcept;
  /// The device must have finished all recorded commands.
  ~VulkanDenoiser();

  /// Records the next frame, outside of a render pass. Submit each command buffer once, in the
  /// order of recording, to one queue.
  ///
  /// Before: writes of the inputs must be visible to VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
  /// VK_ACCESS_SHADER_READ_BIT, and earlier reads of the outputs must be finished. The denoiser
  /// inserts the barriers between its frames and stages. After: the outputs are written by
  /// VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT, and keep their layout;
  /// inputs may be written again after VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT.
  /// \return kInvalidArgument naming the missing image, kOutOfMemory for descriptor sets. Then
  ///     nothing is recorded, and the next frame continues from the last one that was
  Status Record(VkCommandBuffer commands, const VulkanFrame& frame);

  /// Changes the settings from the next frame on; compiles shaders if needed.
  /// \return kInvalidArgument if they are invalid or need other images: `signals`, `limit_history`,
  ///     `feedback`, `firefly` and `wavelet` may; or if they turn on `restore_detail`, which only
  ///     the CPU has
  Status SetSettings(const Settings& settings);
  const Settings& settings() const;
  /// The next frame is a first frame.
  void Reset();
  /// Call this before views that were passed are destroyed, and after the device has finished all
  /// recorded commands. Not necessary with VulkanOptions::frames_in_flight.
  Status ForgetImages();

  DeviceMemory memory() const;
  /// Times of the newest frame that the device has finished, among the last `frames_in_flight` (the
  /// last one alone if that is 0); empty before the first, or without `timestamps`.
  std::vector<StageTime> timings() const;

 private:
  struct Impl;
  explicit VulkanDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillray
