// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser within a renderer's own Vulkan frame: on the renderer's device, images and command
/// buffer. Recording submits no work, does not wait, and allocates no device memory. See
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

/// The maximum number of filtered signals; see VulkanFrame::filtered.
inline constexpr int kVulkanSignals = 4;

/// A part of the renderer's device memory.
struct VulkanMemoryBlock {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;  ///< in bytes, a multiple of the requested alignment
  void* handle = nullptr;   ///< the allocator's own
};

/// The renderer's allocator of device memory. If not given, the denoiser calls vkAllocateMemory.
struct VulkanAllocator {
  void* user = nullptr;
  /// Called by VulkanDenoiser::Create for each block of images and buffers. `need` has the bytes,
  /// the alignment (bufferImageGranularity included), and one memory type, as a bit. The memory is
  /// not mapped.
  /// \return VK_SUCCESS or an error code
  VkResult (*allocate)(void* user, const VkMemoryRequirements* need,
                       VulkanMemoryBlock* block) = nullptr;
  /// Called by the denoiser's destructor, and by Create after a failure.
  void (*free)(void* user, const VulkanMemoryBlock* block) = nullptr;
};

/// The renderer's device. All objects must outlive the denoiser.
struct VulkanContext {
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;
  /// The renderer's cache for the denoiser's pipelines; optional.
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  VulkanAllocator allocator = {};  ///< both functions, or none
};

struct VulkanOptions {
  Settings settings;
  int width = 0;              ///< maximum width of frames, pixels
  int height = 0;             ///< maximum height of frames, pixels
  bool transmission = false;  ///< frames have transmission signals
  DevicePrecision precision = DevicePrecision::kHalf;
  bool timestamps = false;  ///< measure the stages; the queue must support timestamps
  /// Guides may be known only at pixels with a path: pixels with depth 0 and no sample are filled
  /// in on the device (docs/denoiser.md, fill_guides), including virtual guides, which takes
  /// memory. `samples` and `motion` are required then.
  bool incomplete_guides = false;
  /// Frames have virtual guides for reflected light, and with `transmission` for transmitted light;
  /// each gets a filter of its own, which takes memory and time (docs/gpu.md). Used while the
  /// setting `virtual_roughness` is above 0 and `signals` separates these signals (`split` or
  /// `diffuse_specular`).
  bool virtual_guides = false;
  /// Frames may have hit distances in place of depth and motion of `reflection`, which takes 12
  /// bytes per pixel more. Needs `virtual_guides`.
  bool hit_distances = false;
  /// 0: frames reuse a few images; descriptor sets are cached by image view, so that views must
  /// live until ForgetImages. Above 0: every frame may have other views, which must live until the
  /// device has finished the frame. Record then rewrites the descriptor sets of the frame recorded
  /// this many frames ago, which the device must have finished. At most 64.
  int frames_in_flight = 0;
  /// Marks the stages in the command buffer, for debuggers. The instance must have
  /// VK_EXT_debug_utils enabled.
  bool debug_labels = false;
  /// A denoiser on the same device whose pipelines are shared, so that they are compiled once. Read
  /// by Create only; either denoiser may be destroyed first.
  const VulkanDenoiser* share_with = nullptr;
};

/// A plain 2D image (VK_IMAGE_VIEW_TYPE_2D) of at least the frame's size; no view: not given.
/// Usage: SAMPLED for inputs, STORAGE for outputs. Inputs may have any layout that shaders may read
/// from, outputs must be in VK_IMAGE_LAYOUT_GENERAL.
struct VulkanImage {
  VkImageView view = VK_NULL_HANDLE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_GENERAL;
};

/// Guides of virtual images in or behind smooth surfaces: see VirtualGuides. All images must be
/// given (`id` if VulkanFrame::id is), or none.
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
  /// missing, and feeds back only complete samples per pixel; values above 1 act as 1.
  float samples_per_pixel = 1;
  /// See Frame::jitter_x.
  float jitter_x = 0;
  float jitter_y = 0;
  float focal_pixels = 0;  ///< see Frame::focal_pixels
  /// In pixels, at most the size of the options; 0: the size of the options. Images may be larger:
  /// the frame is at their corner (0, 0). When the size changes, the history is resampled.
  int width = 0;
  int height = 0;

  VulkanImage lights[kSignalKindCount];  ///< radiance by SignalKind: r, g, b
  /// See Signal::second_moment. Not estimated here: without them frames with several samples per
  /// pixel are hardly filtered.
  VulkanImage second_moments[kSignalKindCount];
  VulkanImage depth;   ///< known at every pixel, unless `incomplete_guides`
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
  /// `specular_albedo` are required too. A frame without virtual guides begins a new history.
  VulkanVirtualGuides reflection;
  /// With VulkanOptions::hit_distances, in place of `reflection.depth` and `reflection.motion`,
  /// which are computed from it and the cameras (ReflectionsFromHits): length of the reflected ray
  /// from the first surface, in the unit of depth. >= 1e9 and infinity: the sky; 0, negative, NaN:
  /// no virtual image. The other images of `reflection` are optional then: normal and id default to
  /// the mirror's, the albedo to white.
  VulkanImage hit_distance;
  /// Perspective cameras of this and the previous frame, without jitter; in the first frame both
  /// are equal. Read only with `hit_distance`.
  CameraMatrices camera = {};
  CameraMatrices previous_camera = {};
  /// Of transmitted light, if VulkanOptions::transmission is set as well; as `reflection`, with
  /// `transmission_albedo` in place of `specular_albedo`.
  VulkanVirtualGuides refraction;

  /// The result: scene-linear, R32G32B32A32_SFLOAT, or R16G16B16A16_SFLOAT if `colour_is_half`.
  VulkanImage colour;
  bool colour_is_half = false;
  /// The result after exposure, tone curve and sRGB encoding, R8G8B8A8_UNORM; optional.
  VulkanImage display;
  /// The filtered signals, divided by their albedos (at least 0.01), before antialiasing and
  /// without emission, in the format of `colour`; optional. Order by the setting `signals`: `split`
  /// direct diffuse, indirect diffuse, specular, transmission; `diffuse_specular` diffuse,
  /// specular, transmission; `direct_indirect` direct, indirect (divided by the sum of all albedos,
  /// as `single`); `single` one signal; `channels` red, green, blue. Without light that has virtual
  /// guides, which is divided by the albedo of the hit surface as well.
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
  /// \return kInvalidArgument naming the missing image, kOutOfMemory for descriptor sets. Then no
  ///     commands are recorded, and the next frame continues from the last recorded frame
  Status Record(VkCommandBuffer commands, const VulkanFrame& frame);

  /// Changes the settings from the next frame on; compiles shaders if needed.
  /// \return kInvalidArgument if they are invalid or need other images: `signals`, `limit_history`,
  ///     `feedback`, `firefly` and `wavelet` may; or if they turn on `restore_detail`, which only
  ///     the CPU implements
  Status SetSettings(const Settings& settings);
  const Settings& settings() const;
  /// Discards all history: the next frame is a first frame.
  void Reset();
  /// Call this before the views of recorded frames are destroyed, and after the device has finished
  /// all recorded commands. Not necessary with VulkanOptions::frames_in_flight.
  Status ForgetImages();

  /// The device memory in use, as of MemoryNeed.
  DeviceMemory memory() const;
  /// Times of the latest frame that the device has finished, among the last `frames_in_flight`
  /// frames (if that is 0: of the last frame only); empty before the first finished frame, or
  /// without `timestamps`.
  std::vector<StageTime> timings() const;

 private:
  struct Impl;
  explicit VulkanDenoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace stillray
