/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0 */

/* The denoiser for any language that can call C (C99). docs/library.md has examples.
 *
 *  - A device holds the threads; a denoiser holds the settings and history of one sequence.
 *  - The caller owns all images: a denoiser keeps descriptions of their memory, and accesses it
 *    only within stillray_denoiser_execute(), _push() and _pull(). Inputs and outputs may be the
 *    same memory.
 *  - Every function that can fail returns a code; its message is stored in the denoiser, or in the
 *    calling thread for functions without a denoiser.
 *  - Different denoisers may be used by different threads at once, also with one device. A denoiser
 *    accepts one call at a time: a second call, from another thread or from the progress callback,
 *    is rejected (STILLRAY_ERROR_BUSY). There is no global state. The library never prints, throws
 *    or exits.
 *  - Equal frames and settings give equal bits, for any number of threads.
 *  - NULL handles, names and pointers are errors (STILLRAY_ERROR_INVALID_ARGUMENT) unless stated
 *    otherwise; a released handle is invalid.
 *  - Initialise structs that begin with struct_size with their STILLRAY_..._INIT, so that they can
 *    grow: "Versions" in docs/library.md has the rules.
 *
 * Images: pixel (0,0) is the top left, x runs right, y down. Radiance is linear and scene-referred.
 * stillray_input_at() and docs/library.md define each input. */
#ifndef STILLRAY_STILLRAY_H_
#define STILLRAY_STILLRAY_H_

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define STILLRAY_API __attribute__((visibility("default")))
#else
#define STILLRAY_API
#endif

/* The ABI version that a program was compiled against; the library creates no device for another
 * version. The name of the shared library ends in this number. Incremented when compiled programs
 * would break: a function, an argument, a struct member or the value of a constant is removed or
 * changed. Not incremented for new functions, inputs, outputs, settings, error codes and members at
 * the end of structs with struct_size. */
#define STILLRAY_ABI_VERSION 2u

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stillray_device stillray_device;
typedef struct stillray_denoiser stillray_denoiser;

typedef enum stillray_error {
  STILLRAY_OK = 0,
  STILLRAY_ERROR_INVALID_ARGUMENT = 1, /* a caller's error: sizes that differ, unknown names */
  STILLRAY_ERROR_NOT_FOUND = 2,
  STILLRAY_ERROR_BAD_DATA = 3,    /* a saved history that is damaged or of other settings */
  STILLRAY_ERROR_UNSUPPORTED = 4, /* another ABI version */
  STILLRAY_ERROR_IO = 5,
  STILLRAY_ERROR_OUT_OF_MEMORY = 6,
  STILLRAY_ERROR_CANCELLED = 7, /* cancelled by the progress callback */
  STILLRAY_ERROR_INTERNAL = 8,  /* a defect of stillray */
  STILLRAY_ERROR_BUSY = 9       /* another call on this denoiser is running; nothing was done */
} stillray_error;

/* ---- Library -------------------------------------------------------------------------------- */

/* STILLRAY_ABI_VERSION of the loaded library. */
STILLRAY_API uint32_t stillray_abi_version(void);
/* "MAJOR.MINOR.PATCH" of the loaded library. */
STILLRAY_API const char* stillray_version(void);
/* The name of a code: "out of memory", ...; never NULL. */
STILLRAY_API const char* stillray_error_name(int error);

/* ---- Images --------------------------------------------------------------------------------- */

typedef enum stillray_format {
  STILLRAY_FORMAT_FLOAT = 1, /* 32-bit IEEE floats */
  STILLRAY_FORMAT_HALF = 2,  /* 16-bit IEEE floats; outputs are rounded to nearest even */
  STILLRAY_FORMAT_UINT32 = 3 /* only for "id" */
} stillray_format;

/* Channel c of pixel (x, y) lies at data + y * row_stride + x * pixel_stride + c * channel_stride
 * bytes, in any order: interleaved, planar, bottom-up (negative row_stride), part of a larger
 * image. No two elements may share bytes. No alignment is needed. This struct does not grow. */
typedef struct stillray_image {
  void* data;       /* inputs are only read */
  int32_t format;   /* a stillray_format */
  int32_t channels; /* 1 to 4; additional channels of inputs are ignored */
  int32_t width;    /* pixels, 1 to 32768 */
  int32_t height;
  ptrdiff_t pixel_stride;   /* bytes; 0: channels * bytes of the format */
  ptrdiff_t row_stride;     /* bytes; 0: width * pixel_stride */
  ptrdiff_t channel_stride; /* bytes; 0: bytes of the format */
} stillray_image;

/* Tightly packed pixels: RGBRGB... */
STILLRAY_API stillray_image stillray_interleaved(void* data, int32_t format, int32_t channels,
                                                 int32_t width, int32_t height);
/* Tightly packed planes: RR...GG...BB... */
STILLRAY_API stillray_image stillray_planar(void* data, int32_t format, int32_t channels,
                                            int32_t width, int32_t height);

/* ---- Tables of inputs, parameters and presets ----------------------------------------------- */

/* An input image of a frame. All strings of these tables live as long as the program. */
typedef struct stillray_input_info {
  size_t struct_size; /* sizeof(stillray_input_info), by the INIT below */
  const char* name;   /* "direct_diffuse", "albedo", "motion", ... */
  const char* help;   /* one sentence: meaning, unit */
  int32_t channels;   /* minimum number of channels */
} stillray_input_info;
#define STILLRAY_INPUT_INFO_INIT \
  { sizeof(stillray_input_info), NULL, NULL, 0 }

STILLRAY_API size_t stillray_input_count(void);
/* Describes input number index. INVALID_ARGUMENT if index >= count; the message is the thread's. */
STILLRAY_API stillray_error stillray_input_at(size_t index, stillray_input_info* info);

typedef enum stillray_parameter_type {
  STILLRAY_PARAMETER_FLOAT = 0,
  STILLRAY_PARAMETER_INT = 1,
  STILLRAY_PARAMETER_FLAG = 2,   /* "on" or "off" */
  STILLRAY_PARAMETER_CHOICE = 3, /* one of `choices` */
  STILLRAY_PARAMETER_STEPS = 4   /* "1,2,4,8,16" */
} stillray_parameter_type;

typedef struct stillray_parameter {
  size_t struct_size; /* sizeof(stillray_parameter), by the INIT below */
  const char* name;
  const char* help;  /* one sentence */
  const char* group; /* the stage that uses it */
  const char* unit;  /* "" if it has none */
  stillray_parameter_type type;
  double min;                 /* inclusive; for STEPS, of each step */
  double max;                 /* inclusive */
  const char* default_value;  /* as text, in the preset "default" */
  const char* const* choices; /* `choice_count` names; NULL if there are none */
  size_t choice_count;
} stillray_parameter;
#define STILLRAY_PARAMETER_INIT                                                               \
  {                                                                                           \
    sizeof(stillray_parameter), NULL, NULL, NULL, NULL, STILLRAY_PARAMETER_FLOAT, 0, 0, NULL, \
        NULL, 0                                                                               \
  }

STILLRAY_API size_t stillray_parameter_count(void);
/* As stillray_input_at. */
STILLRAY_API stillray_error stillray_parameter_at(size_t index, stillray_parameter* parameter);

STILLRAY_API size_t stillray_preset_count(void);
/* NULL if index >= count. */
STILLRAY_API const char* stillray_preset_name(size_t index);

/* ---- Device --------------------------------------------------------------------------------- */

/* Creates a CPU device. abi_version: pass STILLRAY_ABI_VERSION. threads: 1 to 1024, at most one per
 * processor is used; 0: one per processor.
 * On failure *device is NULL. UNSUPPORTED: the library has
 * another ABI version. INVALID_ARGUMENT: threads is out of range. */
STILLRAY_API stillray_error stillray_device_create(uint32_t abi_version, int32_t threads,
                                                   stillray_device** device);
/* Creates a device by name: "cpu", as stillray_device_create; "vulkan", the first usable Vulkan
 * device, GPUs before software; "vulkan:N", the Nth of `stillray info --devices`; "auto", a GPU if
 * a usable GPU exists, else the CPU. Results of other devices differ from the CPU by rounding. On
 * failure *device is NULL. INVALID_ARGUMENT: an unknown name; NOT_FOUND, UNSUPPORTED: the device
 * does not exist, or lacks a feature. */
STILLRAY_API stillray_error stillray_device_create_on(uint32_t abi_version, int32_t threads,
                                                      const char* name, stillray_device** device);
/* "cpu", or choice, name and driver of another device. Valid as long as the device; "" if device is
 * NULL. */
STILLRAY_API const char* stillray_device_description(const stillray_device* device);
/* Releases a device. Its denoisers remain valid. NULL is allowed. */
STILLRAY_API void stillray_device_release(stillray_device* device);
/* The number of threads; 0 if device is NULL. */
STILLRAY_API int32_t stillray_device_threads(const stillray_device* device);

/* ---- Denoiser ------------------------------------------------------------------------------- */

/* Creates a denoiser. preset: a name, or NULL for "default". On failure *denoiser is NULL, and the
 * message is the thread's. INVALID_ARGUMENT: an unknown preset. */
STILLRAY_API stillray_error stillray_denoiser_create(stillray_device* device, const char* preset,
                                                     stillray_denoiser** denoiser);
/* Releases a denoiser. NULL is allowed. A denoiser with a running call is destroyed when the call
 * returns. */
STILLRAY_API void stillray_denoiser_release(stillray_denoiser* denoiser);

/* One line on the last failed call: of this denoiser, or, if denoiser is NULL, of this thread's
 * calls without a denoiser (creation, NULL handles, tables). "" if no call failed. Valid until the
 * next failed call on this denoiser, or of this thread. */
STILLRAY_API const char* stillray_error_message(const stillray_denoiser* denoiser);

/* Replaces all settings by those of a preset. INVALID_ARGUMENT: an unknown preset. */
STILLRAY_API stillray_error stillray_denoiser_set_preset(stillray_denoiser* denoiser,
                                                         const char* preset);
/* Changes one setting, from text: "0.2", "on", "split", "1,2,4". INVALID_ARGUMENT: an unknown name
 * or an invalid value. Settings that contradict each other are reported by execute, so that they
 * can be changed in any order. History is kept if possible; regrouping signals restarts it. */
STILLRAY_API stillray_error stillray_denoiser_set(stillray_denoiser* denoiser, const char* name,
                                                  const char* value);
/* *value: the setting as text that set() reads back to the same bits; valid until the next call of
 * get() on this denoiser. INVALID_ARGUMENT: an unknown name. */
STILLRAY_API stillray_error stillray_denoiser_get(stillray_denoiser* denoiser, const char* name,
                                                  const char** value);

/* Sets an input image of all following frames; NULL removes it. INVALID_ARGUMENT: an unknown name,
 * or a format, size or number of channels that the input does not allow. */
STILLRAY_API stillray_error stillray_denoiser_set_input(stillray_denoiser* denoiser,
                                                        const char* name,
                                                        const stillray_image* image);
/* Sets the image that receives an output; NULL removes it. "colour" (3 channels) is the denoised
 * image; "variance" (1), the variance of its luminance before the spatial filter, and
 * "history_length" (1), the number of samples in the shortest history, are meant for adaptive
 * samplers; the others are intermediate images. Additional channels of the image are not written.
 * Outputs that a frame lacks (such as "limit" in a first frame) are 0. Errors as set_input. */
STILLRAY_API stillray_error stillray_denoiser_set_output(stillray_denoiser* denoiser,
                                                         const char* name,
                                                         const stillray_image* image);
/* The number and names of the outputs available with the current settings; 0 and NULL on errors,
 * NULL also if index >= count. */
STILLRAY_API size_t stillray_denoiser_output_count(stillray_denoiser* denoiser);
STILLRAY_API const char* stillray_denoiser_output_name(stillray_denoiser* denoiser, size_t index);

/* The jitter of the next frames, in pixels: all rays passed through (x + 0.5 + jitter_x, y + 0.5 +
 * jitter_y). INVALID_ARGUMENT outside of -0.5 to 0.5. The first jitter other than (0, 0) enables
 * temporal antialiasing with antialias=auto. */
STILLRAY_API stillray_error stillray_denoiser_set_jitter(stillray_denoiser* denoiser,
                                                         float jitter_x, float jitter_y);

/* The focal length of the next frames in pixels, which depth_weight=position needs: width / (2
 * tan(horizontal angle of view / 2)), of a perspective camera with square pixels whose axis passes
 * through the image centre. 0 (initially): unknown. INVALID_ARGUMENT if negative or not finite. */
STILLRAY_API stillray_error stillray_denoiser_set_focal_pixels(stillray_denoiser* denoiser,
                                                               float focal_pixels);

/* Called with the completed fraction of the frame, 0 to 1 (estimated from the last frame's time),
 * on the thread that called execute; return 0 to continue, any other value to cancel. Calls on this
 * denoiser from the callback are rejected. */
typedef int (*stillray_progress)(void* user, double fraction);
/* Sets the progress callback of this denoiser; NULL: none. */
STILLRAY_API stillray_error stillray_denoiser_set_progress(stillray_denoiser* denoiser,
                                                           stillray_progress progress, void* user);

/* Denoises the next frame of the sequence. A frame of another size than the last one restarts the
 * history.
 *  INVALID_ARGUMENT  an image is missing or of another size than the others, or settings
 *                    contradict each other: the message names it. History is unchanged.
 *  CANCELLED         no output was written. History is unchanged if nothing was filtered yet
 *                    (fraction was 0), else it restarts.
 *  OUT_OF_MEMORY     no output was written; history restarts. */
STILLRAY_API stillray_error stillray_denoiser_execute(stillray_denoiser* denoiser);

/* The number of the next frame, for messages; initially 0, incremented after every frame. Below one
 * sample per pixel it also selects the rounding of motion: with the numbers of the files, results
 * are bit-identical to `stillray denoise`. */
STILLRAY_API stillray_error stillray_denoiser_set_frame_index(stillray_denoiser* denoiser,
                                                              int64_t index);

/* Fixes the size of the following frames, 1 to 32768 pixels; 0, 0: any size. Removes all inputs,
 * outputs and waiting frames, and frees the memory of another size. Images of another size are then
 * rejected. INVALID_ARGUMENT: a size out of range; nothing changes. */
STILLRAY_API stillray_error stillray_denoiser_resize(stillray_denoiser* denoiser, int32_t width,
                                                     int32_t height);
/* Discards all history and waiting frames: the next frame is a first frame, as at a cut. */
STILLRAY_API stillray_error stillray_denoiser_reset(stillray_denoiser* denoiser);

/* Saves the whole history, to continue later with identical results on the same kind of device with
 * the same driver. *size: bytes needed. buffer NULL: only returns the size. INVALID_ARGUMENT if
 * capacity is below the size; nothing is written then. */
STILLRAY_API stillray_error stillray_denoiser_save_history(stillray_denoiser* denoiser,
                                                           void* buffer, size_t capacity,
                                                           size_t* size);
/* Restores a saved history. BAD_DATA if the bytes are damaged or were saved with other settings;
 * history is then unchanged. */
STILLRAY_API stillray_error stillray_denoiser_restore_history(stillray_denoiser* denoiser,
                                                              const void* buffer, size_t size);

/* ---- Light of the past and of the future ----------------------------------------------------- */

/* Frames are pushed one by one and pulled in the same order after a delay, denoised with light of
 * later frames too: first frames and disoccluded surfaces become as clean as other pixels. Results
 * are bit-identical to `stillray denoise --window both`. The sequence is divided into blocks of 16
 * frames; a block is ready once 16 later frames are pushed, or the sequence is finished. At most 32
 * frames are held if every ready frame is pulled before the next push. "Past and future" in
 * docs/library.md shows the loop. */

typedef enum stillray_cut {
  STILLRAY_CUT_FIND = 0, /* a cut where hardly any surface of the previous frame is found again */
  STILLRAY_CUT_YES = 1,  /* a cut: the frame's motion is not used */
  STILLRAY_CUT_NO = 2    /* no cut */
} stillray_cut;

/* Copies the inputs as the next frame of the sequence; also reads the input "next_motion". The
 * first push after a finished and pulled sequence begins another sequence. cut: a stillray_cut.
 *  INVALID_ARGUMENT  as execute, or settings were changed, or the sequence is finished, while its
 *                    frames wait. The sequence is unchanged.
 *  OUT_OF_MEMORY     the waiting frames are discarded. */
STILLRAY_API stillray_error stillray_denoiser_push(stillray_denoiser* denoiser, int32_t cut);
/* Ends the sequence with the last frame that was pushed: all waiting frames become ready. */
STILLRAY_API stillray_error stillray_denoiser_finish(stillray_denoiser* denoiser);
/* Denoises the next frame and writes its outputs. *pulled: 0 if no frame is ready, else 1. Calls
 * the progress callback. The first call of a block processes up to 32 frames, the others one frame.
 *  INVALID_ARGUMENT  an output is of another size than the frame, or no output is set. The frame
 *                    still waits.
 *  CANCELLED         no frame is lost: another call repeats the work. Once the frame itself is
 *                    being denoised, it is finished despite the request.
 *  OUT_OF_MEMORY     the waiting frames are discarded. */
STILLRAY_API stillray_error stillray_denoiser_pull(stillray_denoiser* denoiser, int32_t* pulled);

/* The frames that were pushed and not yet pulled. */
typedef struct stillray_waiting {
  size_t struct_size; /* sizeof(stillray_waiting), by the INIT below */
  size_t frames;
  int32_t ready;  /* 1 if pull has a frame to finish, else 0 */
  int32_t width;  /* of the frame to be pulled next; 0 if none waits */
  int32_t height; /* of the frame to be pulled next; 0 if none waits */
  int64_t index;  /* of the frame to be pulled next; 0 if none waits */
} stillray_waiting;
#define STILLRAY_WAITING_INIT \
  { sizeof(stillray_waiting), 0, 0, 0, 0, 0 }
STILLRAY_API stillray_error stillray_denoiser_waiting(stillray_denoiser* denoiser,
                                                      stillray_waiting* waiting);

/* Memory in bytes that a sequence of pushed frames will take. */
typedef struct stillray_memory_need {
  size_t struct_size; /* sizeof(stillray_memory_need), by the INIT below */
  size_t denoisers;   /* history and working memory of both directions */
  size_t per_future;  /* accumulated light of later frames, for one frame; 16 are held */
  size_t per_frame;   /* a waiting frame; 32 are held */
  size_t most;        /* sum of all */
} stillray_memory_need;
#define STILLRAY_MEMORY_NEED_INIT \
  { sizeof(stillray_memory_need), 0, 0, 0, 0 }
/* Memory for frames with the current inputs, whose pixels are not read: data may be any address.
 * Exact on the CPU for frames with at least one sample per pixel; below, or with unknown guides, up
 * to 400 bytes per pixel more. */
STILLRAY_API stillray_error stillray_denoiser_memory_need(stillray_denoiser* denoiser,
                                                          stillray_memory_need* need);

/* ---- Reflections ------------------------------------------------------------------------------
 */

/* A perspective camera: row-major matrices for column vectors (docs/cameras.md). world_to_camera: x
 * right, y up, viewing direction -z or z. projection: camera to clip space of any graphics API; the
 * direction of y is inferred, and the row of z is ignored. This struct does not grow. */
typedef struct stillray_camera {
  double world_to_camera[16];
  double projection[16];
} stillray_camera;

/* Inputs and outputs of stillray_reflections_from_hits. All images have the same size. */
typedef struct stillray_hits {
  size_t struct_size; /* sizeof(stillray_hits), by the INIT below */
  /* Inputs, as the inputs of a denoiser. 1 channel: */
  const stillray_image* depth;
  /* Length of the reflected ray from the first surface to its hit, in the unit of depth. >= 1e9 and
   * infinity: the sky; 0, negative, NaN: unknown, no virtual image. */
  const stillray_image* hit_distance;
  const stillray_image* roughness;        /* or NULL: virtual images where neighbours agree */
  const stillray_image* normal;           /* 3 channels, or NULL; with id, separates surfaces */
  const stillray_image* id;               /* or NULL */
  const stillray_camera* camera;          /* without jitter */
  const stillray_camera* previous_camera; /* in the first frame: equal to camera */
  /* Outputs, for the denoiser's inputs of these names; 1 and 2 channels. */
  const stillray_image* reflection_depth;
  const stillray_image* reflection_motion;
} stillray_hits;
#define STILLRAY_HITS_INIT \
  { sizeof(stillray_hits), NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL }

/* Computes virtual guides of reflections from hit distances: see ReflectionsFromHits in
 * docs/library.md. The message is the thread's. INVALID_ARGUMENT: an image is missing or of another
 * size than the depth, or a camera has no perspective; no output is written then. */
STILLRAY_API stillray_error stillray_reflections_from_hits(const stillray_hits* hits);

/* ---- Statistics ------------------------------------------------------------------------------ */

/* Statistics of the last frame. */
typedef struct stillray_statistics {
  size_t struct_size; /* sizeof(stillray_statistics), by the INIT below */
  int64_t non_finite; /* pixels with NaN or infinite radiance, per signal, treated as missing */
  int64_t negative;   /* pixels with radiance below -1/1024 of its mean, treated as missing; smaller
                         negative values count as 0 */
  /* pixels with an invalid depth or normal, which are not filtered, or with NaN as confidence */
  int64_t bad_guides;
  size_t memory_bytes; /* history and working memory in use */
  double filter_ms;    /* time of all stages, without copying images in and out */
} stillray_statistics;
#define STILLRAY_STATISTICS_INIT \
  { sizeof(stillray_statistics), 0, 0, 0, 0, 0 }
STILLRAY_API stillray_error stillray_denoiser_statistics(stillray_denoiser* denoiser,
                                                         stillray_statistics* statistics);
/* A one-line warning about the last frame, which was denoised nevertheless: for example all normals
 * are zero, or motion is nowhere finite. "" if there is no warning, or denoiser is NULL or busy.
 * Valid until the next call of this function. */
STILLRAY_API const char* stillray_denoiser_warning(stillray_denoiser* denoiser);

#ifdef __cplusplus
}
#endif

#endif /* STILLRAY_STILLRAY_H_ */
