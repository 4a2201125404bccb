/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0
 *
 * The denoiser within a renderer's own Vulkan frame, in C: on the renderer's device, images and
 * command buffer. stillray/vulkan.hpp and docs/gpu.md define the rules for images, layouts and
 * barriers, stillray/stillray.h those for errors and structs with struct_size. */
#ifndef STILLRAY_VULKAN_H_
#define STILLRAY_VULKAN_H_

#include <vulkan/vulkan_core.h>

#include "stillray/stillray.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stillray_vulkan_denoiser stillray_vulkan_denoiser;

/* A part of the renderer's device memory. This struct does not grow. */
typedef struct stillray_vulkan_memory_block {
  VkDeviceMemory memory;
  VkDeviceSize offset; /* in bytes, a multiple of the requested alignment */
  void* handle;        /* the allocator's own */
} stillray_vulkan_memory_block;

/* The renderer's allocator of device memory: see VulkanAllocator of stillray/vulkan.hpp. Both
 * functions, or none: the denoiser then calls vkAllocateMemory. This struct does not grow. */
typedef struct stillray_vulkan_allocator {
  void* user;
  VkResult (*allocate)(void* user, const VkMemoryRequirements* need,
                       stillray_vulkan_memory_block* block);
  void (*free)(void* user, const stillray_vulkan_memory_block* block);
} stillray_vulkan_allocator;

/* The renderer's device; all must outlive the denoiser. */
typedef struct stillray_vulkan_context {
  size_t struct_size; /* sizeof(stillray_vulkan_context), by the INIT below */
  VkInstance instance;
  VkPhysicalDevice physical_device;
  VkDevice device;
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  VkPipelineCache pipeline_cache; /* the renderer's, for the denoiser's pipelines; optional */
  stillray_vulkan_allocator allocator;
} stillray_vulkan_context;
#define STILLRAY_VULKAN_CONTEXT_INIT                                                 \
  {                                                                                  \
    sizeof(stillray_vulkan_context), VK_NULL_HANDLE, VK_NULL_HANDLE, VK_NULL_HANDLE, \
        (PFN_vkGetInstanceProcAddr)0, VK_NULL_HANDLE, {                              \
      NULL, NULL, NULL                                                               \
    }                                                                                \
  }

typedef struct stillray_vulkan_options {
  size_t struct_size;          /* sizeof(stillray_vulkan_options), by the INIT below */
  const char* preset;          /* NULL: "default" */
  const char* const* settings; /* "name=value" each, on top of the preset; may be NULL */
  size_t setting_count;
  int32_t width;
  int32_t height;
  int32_t transmission;   /* not 0: frames have transmission signals */
  int32_t full_precision; /* not 0: radiance is stored in 32 bits, with twice the memory */
  int32_t timestamps;     /* not 0: measure the stages */
  /* not 0: pixels with depth 0 and no sample have unknown guides, which are filled in */
  int32_t incomplete_guides;
  /* not 0: frames have virtual guides for reflected and transmitted light */
  int32_t virtual_guides;
  /* 0: frames reuse a few image views, which must live until forget_images. Above 0: views live for
   * one frame, and this many frames may be unfinished: see VulkanOptions. */
  int32_t frames_in_flight;
  int32_t debug_labels; /* not 0: marks the stages by VK_EXT_debug_utils, which must be enabled */
  /* A denoiser on the same device whose pipelines are shared; or NULL. */
  const stillray_vulkan_denoiser* share_with;
  /* not 0: frames may have hit distances in place of depth and motion of reflections; needs
   * virtual_guides */
  int32_t hit_distances;
} stillray_vulkan_options;
#define STILLRAY_VULKAN_OPTIONS_INIT \
  { sizeof(stillray_vulkan_options), NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, NULL, 0 }

/* Indices of the images in stillray_vulkan_frame. */
typedef enum stillray_vulkan_slot {
  STILLRAY_VULKAN_DIRECT_DIFFUSE = 0,
  STILLRAY_VULKAN_INDIRECT_DIFFUSE = 1,
  STILLRAY_VULKAN_DIRECT_SPECULAR = 2,
  STILLRAY_VULKAN_INDIRECT_SPECULAR = 3,
  STILLRAY_VULKAN_DIRECT_TRANSMISSION = 4,
  STILLRAY_VULKAN_INDIRECT_TRANSMISSION = 5,
  STILLRAY_VULKAN_SECOND_MOMENT = 6, /* of direct diffuse; the other signals follow, to 11 */
  STILLRAY_VULKAN_DEPTH = 12,
  STILLRAY_VULKAN_NORMAL = 13,
  STILLRAY_VULKAN_ID = 14,
  STILLRAY_VULKAN_MOTION = 15,
  STILLRAY_VULKAN_ALBEDO = 16,
  STILLRAY_VULKAN_SPECULAR_ALBEDO = 17,
  STILLRAY_VULKAN_TRANSMISSION_ALBEDO = 18,
  STILLRAY_VULKAN_EMISSION = 19,
  STILLRAY_VULKAN_BACKGROUND = 20,
  STILLRAY_VULKAN_SAMPLES = 21,
  STILLRAY_VULKAN_COLOUR = 22,  /* output */
  STILLRAY_VULKAN_DISPLAY = 23, /* output */
  STILLRAY_VULKAN_ROUGHNESS = 24,
  STILLRAY_VULKAN_CONFIDENCE = 25,      /* 0 to 1: factor of the history length */
  STILLRAY_VULKAN_PREVIOUS_NORMAL = 26, /* of the point one frame ago; zero: as the normal */
  /* Virtual guides of reflections: all, with virtual_guides, or none. */
  STILLRAY_VULKAN_REFLECTION_DEPTH = 27,
  STILLRAY_VULKAN_REFLECTION_NORMAL = 28,
  STILLRAY_VULKAN_REFLECTION_MOTION = 29,
  STILLRAY_VULKAN_REFLECTION_ID = 30,
  STILLRAY_VULKAN_REFLECTION_ALBEDO = 31,
  /* Virtual guides of refractions: all, with virtual_guides and transmission, or none. */
  STILLRAY_VULKAN_REFRACTION_DEPTH = 32,
  STILLRAY_VULKAN_REFRACTION_NORMAL = 33,
  STILLRAY_VULKAN_REFRACTION_MOTION = 34,
  STILLRAY_VULKAN_REFRACTION_ID = 35,
  STILLRAY_VULKAN_REFRACTION_ALBEDO = 36,
  /* Outputs: the filtered signals, see VulkanFrame::filtered; 3 more follow. */
  STILLRAY_VULKAN_FILTERED = 37,
  /* With hit_distances, replaces depth and motion of the reflection: the length of the reflected
   * ray. Needs the cameras of the frame; the other images of the reflection are optional then. */
  STILLRAY_VULKAN_HIT_DISTANCE = 41,
  STILLRAY_VULKAN_SLOT_COUNT = 42
} stillray_vulkan_slot;
/* Capacity of stillray_vulkan_frame. */
#define STILLRAY_VULKAN_SLOT_ROOM 48

/* This struct does not grow. */
typedef struct stillray_vulkan_image {
  VkImageView view; /* VK_NULL_HANDLE: not given */
  VkImageLayout layout;
} stillray_vulkan_image;

typedef struct stillray_vulkan_frame {
  size_t struct_size; /* sizeof(stillray_vulkan_frame), by the INIT below */
  int64_t index;
  float samples_per_pixel; /* mean of the frame; values above 1 act as 1 */
  int32_t colour_is_half;  /* not 0: R16G16B16A16_SFLOAT, else R32G32B32A32_SFLOAT */
  float jitter_x;          /* see stillray_denoiser_set_jitter */
  float jitter_y;
  stillray_vulkan_image images[STILLRAY_VULKAN_SLOT_ROOM];
  float focal_pixels; /* see stillray_denoiser_set_focal_pixels */
  float reserved;     /* 0 */
  /* In pixels, at most the size of the options; 0: the size of the options. See VulkanFrame. */
  int32_t width;
  int32_t height;
  /* Of this and the previous frame, without jitter; read only with hit distances. */
  const stillray_camera* camera;
  const stillray_camera* previous_camera;
} stillray_vulkan_frame;
#define STILLRAY_VULKAN_FRAME_INIT                                                  \
  {                                                                                 \
    sizeof(stillray_vulkan_frame), 0, 1.0f, 0, 0.0f, 0.0f,                          \
        {{VK_NULL_HANDLE, VK_IMAGE_LAYOUT_UNDEFINED}}, 0.0f, 0.0f, 0, 0, NULL, NULL \
  }

typedef struct stillray_vulkan_memory {
  size_t struct_size; /* sizeof(stillray_vulkan_memory), by the INIT below */
  uint32_t allocations;
  uint32_t resources; /* images and buffers */
  uint64_t bytes;
  uint64_t largest_bytes; /* of the largest image or buffer */
} stillray_vulkan_memory;
#define STILLRAY_VULKAN_MEMORY_INIT \
  { sizeof(stillray_vulkan_memory), 0, 0, 0, 0 }

/* The device memory that create would allocate; allocates nothing. The message is that of
 * stillray_vulkan_error_message(NULL). */
STILLRAY_API stillray_error stillray_vulkan_memory_need(const stillray_vulkan_context* context,
                                                        const stillray_vulkan_options* options,
                                                        stillray_vulkan_memory* need);
/* Creates a denoiser; see VulkanDenoiser::Create for errors. abi_version: pass
 * STILLRAY_ABI_VERSION. On failure *denoiser is NULL, and the message is that of
 * stillray_vulkan_error_message(NULL). */
STILLRAY_API stillray_error stillray_vulkan_create(uint32_t abi_version,
                                                   const stillray_vulkan_context* context,
                                                   const stillray_vulkan_options* options,
                                                   stillray_vulkan_denoiser** denoiser);
/* Releases a denoiser. The device must have finished all recorded commands. NULL is allowed. */
STILLRAY_API void stillray_vulkan_release(stillray_vulkan_denoiser* denoiser);
/* Records the next frame: see VulkanDenoiser::Record. */
STILLRAY_API stillray_error stillray_vulkan_record(stillray_vulkan_denoiser* denoiser,
                                                   VkCommandBuffer commands,
                                                   const stillray_vulkan_frame* frame);
/* Changes one setting from the next frame on: see VulkanDenoiser::SetSettings. */
STILLRAY_API stillray_error stillray_vulkan_set(stillray_vulkan_denoiser* denoiser,
                                                const char* name, const char* value);
/* Discards all history: the next frame is a first frame. */
STILLRAY_API stillray_error stillray_vulkan_reset(stillray_vulkan_denoiser* denoiser);
/* Call this before the views of recorded frames are destroyed. */
STILLRAY_API stillray_error stillray_vulkan_forget_images(stillray_vulkan_denoiser* denoiser);
/* Milliseconds of all stages of the latest frame that the device has finished, among the last
 * frames_in_flight frames (if that is 0: of the last frame only); negative before the first
 * finished frame, or without timestamps. */
STILLRAY_API double stillray_vulkan_filter_ms(const stillray_vulkan_denoiser* denoiser);

/* This struct does not grow. */
typedef struct stillray_vulkan_stage_time {
  char name[32]; /* of docs/denoiser.md; null-terminated */
  double milliseconds;
} stillray_vulkan_stage_time;
/* The times of the stages of the same frame as filter_ms, in the order of the pipeline. Writes at
 * most `room` elements; `times` may be NULL if room is 0. Returns the number of stages: 0 where
 * filter_ms is negative. */
STILLRAY_API size_t stillray_vulkan_stage_times(const stillray_vulkan_denoiser* denoiser,
                                                stillray_vulkan_stage_time* times, size_t room);
/* One line on the last failed call: of this denoiser, or, if denoiser is NULL, of this thread's
 * calls without a denoiser. */
STILLRAY_API const char* stillray_vulkan_error_message(const stillray_vulkan_denoiser* denoiser);

#ifdef __cplusplus
}
#endif

#endif /* STILLRAY_VULKAN_H_ */
