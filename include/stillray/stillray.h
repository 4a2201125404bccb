/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0 */

/* The denoiser for any language that can call C (C99). docs/library.md shows it at work.
 *
 *  - A device holds the threads; a denoiser holds the settings and history of one sequence.
 *  - The caller owns all images: a denoiser keeps descriptions of the memory, and accesses it only
 *    within stillray_denoiser_execute(), _push() and _pull(). Inputs and outputs may be the same
 *    memory.
 *  - Every function that can fail returns a code; the message is kept by the object it was called
 *    on, or by the calling thread where there is no object.
 *  - Different objects may be used by different threads at once, also with one device; one denoiser
 *    by one call at a time: a second one, from another thread or from the progress callback, is
 *    rejected (STILLRAY_ERROR_BUSY). There is no global state. The library never prints, throws or
 *    exits.
 *  - The same frames and settings give the same bits, whatever the number of threads.
 *  - NULL handles, names and pointers are errors (STILLRAY_ERROR_INVALID_ARGUMENT) unless stated
 *    otherwise; a released handle is invalid.
 *  - Initialise structs that begin with struct_size with their STILLRAY_..._INIT, so that they can
 *    grow: "Versions" in docs/library.md has the rules.
 *
 * Pictures: pixel (0,0) is the top left, x runs right, y down. Radiance is linear and
 * scene-referred. stillray_input_at() and docs/library.md define each input. */
#ifndef STILLRAY_STILLRAY_H_
#define STILLRAY_STILLRAY_H_

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define STILLRAY_API __attribute__((visibility("default")))
#else
#define STILLRAY_API
#endif

/* The ABI that a program was compiled against; the library creates no device for another version.
 * The name of the shared library ends in the same number. Incremented when compiled programs would
 * break: a function, an argument, a struct member or the value of a constant is removed or changed.
 * Not incremented for new functions, inputs, outputs, settings, error codes and members at the end
 * of structs with struct_size. */
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
  STILLRAY_ERROR_BAD_DATA = 3,    /* a saved history that is damaged or has other settings */
  STILLRAY_ERROR_UNSUPPORTED = 4, /* another ABI version */
  STILLRAY_ERROR_IO = 5,
  STILLRAY_ERROR_OUT_OF_MEMORY = 6,
  STILLRAY_ERROR_CANCELLED = 7, /* cancelled by the progress callback */
  STILLRAY_ERROR_INTERNAL = 8,  /* a defect of stillray */
  STILLRAY_ERROR_BUSY = 9       /* another call on this denoiser is running; nothing was done */
} stillray_error;

/* ---- Library -------------------------------------------------------------------------------- */

/* STILLRAY_ABI_VERSION of the library that is running. */
STILLRAY_API uint32_t stillray_abi_version(void);
/* "MAJOR.MINOR.PATCH" of the library that is running. */
STILLRAY_API const char* stillray_version(void);
/* "out of memory", ...; never NULL. */
STILLRAY_API const char* stillray_error_name(int error);

/* ---- Images --------------------------------------------------------------------------------- */

typedef enum stillray_format {
  STILLRAY_FORMAT_FLOAT = 1, /* 32-bit IEEE floats */
  STILLRAY_FORMAT_HALF = 2,  /* 16-bit IEEE floats; outputs are rounded to nearest even */
  STILLRAY_FORMAT_UINT32 = 3 /* only for "id" */
} stillray_format;

/* Channel c of pixel (x, y) lies at data + y * row_stride + x * pixel_stride + c * channel_stride
 * bytes, in any order: interleaved, planar, bottom-up (negative row_stride), part of a larger
 * picture. No two elements may share bytes. No alignment is needed. This struct does not grow. */
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

/* An image that a frame may have. All strings here live as long as the program. */
typedef struct stillray_input_info {
  size_t struct_size; /* sizeof(stillray_input_info), by the INIT below */
  const char* name;   /* "direct_diffuse", "albedo", "motion", ... */
  const char* help;   /* one sentence: meaning, unit */
  int32_t channels;   /* minimum number of channels */
} stillray_input_info;
#define STILLRAY_INPUT_INFO_INIT \
  { sizeof(stillray_input_info), NULL, NULL, 0 }

STILLRAY_API size_t stillray_input_count(void);
/* INVALID_ARGUMENT if index is not below the count; the message is the thread's. */
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
  const char* group; /* the stage that reads it */
  const char* unit;  /* "" if it has none */
  stillray_parameter_type type;
  double min; /* inclusive; of each step for STEPS */
  double max;
  const char* default_value;  /* as text, of the preset "default" */
  const char* const* choices; /* `choice_count` names; NULL if there are none */
  size_t choice_count;
} stillray_parameter;
#define STILLRAY_PARAMETER_INIT                                                               \
  {                                                                                           \
    sizeof(stillray_parameter), NULL, NULL, NULL, NULL, STILLRAY_PARAMETER_FLOAT, 0, 0, NULL, \
        NULL, 0                                                                               \
  }

STILLRAY_API size_t stillray_parameter_count(void);
STILLRAY_API stillray_error stillray_parameter_at(size_t index, stillray_parameter* parameter);

STILLRAY_API size_t stillray_preset_count(void);
/* NULL if index is not below the count. */
STILLRAY_API const char* stillray_preset_name(size_t index);

/* ---- Device --------------------------------------------------------------------------------- */

/* abi_version: pass STILLRAY_ABI_VERSION. threads: 1 to 1024, at most one per processor is
 * used; 0: one per processor.
 * On failure *device is NULL. UNSUPPORTED: the library has another ABI version. */
STILLRAY_API stillray_error stillray_device_create(uint32_t abi_version, int32_t threads,
                                                   stillray_device** device);
/* The same for a device by name: "cpu", as stillray_device_create; "vulkan", the first usable
 * Vulkan device, GPUs before software; "vulkan:N", the Nth of `stillray info --devices`; "auto", a
 * GPU if a usable one exists, else the CPU. On other devices than the CPU the picture differs by
 * rounding.
 * On failure *device is NULL. INVALID_ARGUMENT: an unknown name; NOT_FOUND, UNSUPPORTED: no such
 * device, or a feature that it lacks. */
STILLRAY_API stillray_error stillray_device_create_on(uint32_t abi_version, int32_t threads,
                                                      const char* name, stillray_device** device);
/* "cpu", or choice, name and driver of another device. Lives as long as the device; "" if it is
 * NULL. */
STILLRAY_API const char* stillray_device_description(const stillray_device* device);
/* Its denoisers remain valid. NULL is allowed. */
STILLRAY_API void stillray_device_release(stillray_device* device);
/* The number of threads; 0 if device is NULL. */
STILLRAY_API int32_t stillray_device_threads(const stillray_device* device);

/* ---- Denoiser ------------------------------------------------------------------------------- */

/* preset: a name, or NULL for "default". On failure *denoiser is NULL, the message is the
 * thread's. */
STILLRAY_API stillray_error stillray_denoiser_create(stillray_device* device, const char* preset,
                                                     stillray_denoiser** denoiser);
/* NULL is allowed. A denoiser with a running call is destroyed when the call returns. */
STILLRAY_API void stillray_denoiser_release(stillray_denoiser* denoiser);

/* One line on the last call that failed: of this denoiser, or, if it is NULL, of this thread's
 * calls without a denoiser (creation, NULL handles, tables). "" if none failed. Valid until the
 * next failure of the same kind. */
STILLRAY_API const char* stillray_error_message(const stillray_denoiser* denoiser);

/* All settings of a preset. */
STILLRAY_API stillray_error stillray_denoiser_set_preset(stillray_denoiser* denoiser,
                                                         const char* preset);
/* One setting, from text: "0.2", "on", "split", "1,2,4". Settings that contradict each other are
 * reported by execute, so that they can be changed in any order. History is kept where it can be:
 * regrouping signals restarts it. */
STILLRAY_API stillray_error stillray_denoiser_set(stillray_denoiser* denoiser, const char* name,
                                                  const char* value);
/* *value: text that set() reads back to the same bits, valid until the next call of get(). */
STILLRAY_API stillray_error stillray_denoiser_get(stillray_denoiser* denoiser, const char* name,
                                                  const char** value);

/* Sets an image of the following frames, until changed; NULL removes it. */
STILLRAY_API stillray_error stillray_denoiser_set_input(stillray_denoiser* denoiser,
                                                        const char* name,
                                                        const stillray_image* image);
/* Sets the image that receives a result; NULL removes it. "colour" (3 channels) is the picture;
 * "variance" (1) the variance of its luminance before the spatial filter, and "history_length" (1)
 * the samples in the shortest history, steer adaptive samplers; the others are intermediate
 * pictures. Additional channels of the image are not written. Results that a frame lacks
 * (such as "limit" in a first frame) are 0. */
STILLRAY_API stillray_error stillray_denoiser_set_output(stillray_denoiser* denoiser,
                                                         const char* name,
                                                         const stillray_image* image);
/* The results available with the current settings; 0 and NULL if there are none. */
STILLRAY_API size_t stillray_denoiser_output_count(stillray_denoiser* denoiser);
STILLRAY_API const char* stillray_denoiser_output_name(stillray_denoiser* denoiser, size_t index);

/* All rays of the next frames went through (x + 0.5 + jitter_x, y + 0.5 + jitter_y); -0.5 to 0.5.
 * From the first jitter other than (0, 0) on, antialias=auto antialiases in time. */
STILLRAY_API stillray_error stillray_denoiser_set_jitter(stillray_denoiser* denoiser,
                                                         float jitter_x, float jitter_y);

/* The distance of the picture plane of the next frames in pixels, which depth_weight=position
 * needs: width / (2 tan(horizontal angle of view / 2)). Of a perspective camera whose axis passes
 * through the centre of the picture, with square pixels. 0, as before the first call: unknown. */
STILLRAY_API stillray_error stillray_denoiser_set_focal_pixels(stillray_denoiser* denoiser,
                                                               float focal_pixels);

/* Called with the completed fraction of the frame, 0 to 1 (estimated from the last frame's time),
 * on the thread that called execute; return 0 to continue, any other value to cancel. Calls on the
 * same denoiser from the callback are rejected. */
typedef int (*stillray_progress)(void* user, double fraction);
/* progress may be NULL: none. */
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

/* The number of the next frame, which messages name and which counts up by itself; at first 0. With
 * the numbers of files, sparse frames get the bits of `stillray denoise`: below one sample per
 * pixel the number selects how motion is rounded. */
STILLRAY_API stillray_error stillray_denoiser_set_frame_index(stillray_denoiser* denoiser,
                                                              int64_t index);

/* Fixes the size of the following frames: removes all inputs and outputs and all frames that wait,
 * frees the memory of the old size, and rejects images of another size. 0, 0: any size. */
STILLRAY_API stillray_error stillray_denoiser_resize(stillray_denoiser* denoiser, int32_t width,
                                                     int32_t height);
/* Discards all history and all frames that wait: the next frame is a first frame, as after a cut.
 */
STILLRAY_API stillray_error stillray_denoiser_reset(stillray_denoiser* denoiser);

/* The whole history, to continue later with the same bits, on the same kind of device with the same
 * driver. *size: bytes needed. buffer NULL: only returns the size; a capacity below it is
 * INVALID_ARGUMENT, and nothing is written. */
STILLRAY_API stillray_error stillray_denoiser_save_history(stillray_denoiser* denoiser,
                                                           void* buffer, size_t capacity,
                                                           size_t* size);
/* BAD_DATA if the bytes are damaged or of other settings; history is then unchanged. */
STILLRAY_API stillray_error stillray_denoiser_restore_history(stillray_denoiser* denoiser,
                                                              const void* buffer, size_t size);

/* ---- Light of the past and of the future ----------------------------------------------------- */

/* Frames are pushed one by one; finished ones are pulled in the same order, some later, denoised
 * with light of later frames too: first frames and freshly uncovered surfaces come out as clean as
 * the rest, with the bits of `stillray denoise --window both`. Frames fall into blocks of 16; a
 * block is ready once 16 frames behind it are pushed, or the sequence is finished. At most 32
 * frames are held if every ready one is pulled before the next is pushed. "Past and future" in
 * docs/library.md shows the loop. */

typedef enum stillray_cut {
  STILLRAY_CUT_FIND = 0, /* where hardly any surface of the frame before is found again */
  STILLRAY_CUT_YES = 1,  /* the frame begins a shot: its motion is not used */
  STILLRAY_CUT_NO = 2
} stillray_cut;

/* Copies the inputs as the next frame of the sequence; the input "next_motion" counts here. After a
 * sequence that is finished and pulled it begins another. cut: a stillray_cut.
 *  INVALID_ARGUMENT  as execute, or settings were changed, or the sequence is finished, while its
 *                    frames wait. The sequence is unchanged.
 *  OUT_OF_MEMORY     the frames that wait are dropped. */
STILLRAY_API stillray_error stillray_denoiser_push(stillray_denoiser* denoiser, int32_t cut);
/* The sequence ends with the last frame that was pushed: all frames that wait are ready. */
STILLRAY_API stillray_error stillray_denoiser_finish(stillray_denoiser* denoiser);
/* Finishes the next frame and writes its outputs. *pulled: 0 if no frame is ready, else 1. The
 * progress callback is called while this works: on up to 32 frames in the first call of a block, on
 * one in the others.
 *  INVALID_ARGUMENT  an output is of another size than the frame, or none is set. The frame waits.
 *  CANCELLED         nothing is lost: another call does the work again. Once the frame itself is
 *                    being denoised it is finished.
 *  OUT_OF_MEMORY     the frames that wait are dropped. */
STILLRAY_API stillray_error stillray_denoiser_pull(stillray_denoiser* denoiser, int32_t* pulled);

/* Frames that were pushed and not yet pulled. */
typedef struct stillray_waiting {
  size_t struct_size; /* sizeof(stillray_waiting), by the INIT below */
  size_t frames;
  int32_t ready;  /* 1 if pull has a frame to finish, else 0 */
  int32_t width;  /* of the frame to be pulled next; 0 if none waits */
  int32_t height; /* likewise */
  int64_t index;  /* of the frame to be pulled next; 0 if none waits */
} stillray_waiting;
#define STILLRAY_WAITING_INIT \
  { sizeof(stillray_waiting), 0, 0, 0, 0, 0 }
STILLRAY_API stillray_error stillray_denoiser_waiting(stillray_denoiser* denoiser,
                                                      stillray_waiting* waiting);

/* Bytes that a sequence of pushed frames will take. */
typedef struct stillray_memory_need {
  size_t struct_size; /* sizeof(stillray_memory_need), by the INIT below */
  size_t denoisers;   /* history and working memory of both directions */
  size_t per_future;  /* light of the later frames of one frame, of which 16 are held */
  size_t per_frame;   /* a frame that waits, of which 32 are held */
  size_t most;        /* all that together */
} stillray_memory_need;
#define STILLRAY_MEMORY_NEED_INIT \
  { sizeof(stillray_memory_need), 0, 0, 0, 0 }
/* For frames with the inputs that are set now, whose memory is not read: data may be any address.
 * Exact on the CPU for frames with one sample per pixel or more; with less, or where guides are
 * unknown, up to 400 bytes per pixel come on top. */
STILLRAY_API stillray_error stillray_denoiser_memory_need(stillray_denoiser* denoiser,
                                                          stillray_memory_need* need);

/* ---- Reflections ------------------------------------------------------------------------------
 */

/* A perspective camera, by matrices for column vectors, row by row (docs/cameras.md): x to the
 * right, y up, looking along -z or z; and from there to clip space, of any graphics interface: the
 * direction of y is recognised, and the row of z is not used. This struct does not grow. */
typedef struct stillray_camera {
  double world_to_camera[16];
  double projection[16];
} stillray_camera;

/* The length of reflected rays, and what becomes of it. Images are of one size. */
typedef struct stillray_hits {
  size_t struct_size; /* sizeof(stillray_hits), by the INIT below */
  /* Inputs, as those of a denoiser. 1 channel: */
  const stillray_image* depth;
  /* From the first surface to what the ray met, in the unit of depth. >= 1e9 and infinity: the sky;
   * 0, negative, NaN: not known, no image. */
  const stillray_image* hit_distance;
  const stillray_image* roughness; /* or NULL: images where neighbours agree */
  const stillray_image* normal;    /* or NULL; with id, tells surfaces apart without roughness */
  const stillray_image* id;        /* or NULL */
  const stillray_camera* camera;   /* without jitter */
  const stillray_camera* previous_camera; /* of the first frame: the same */
  /* Outputs: the inputs of a denoiser of these names, 1 and 2 channels. */
  const stillray_image* reflection_depth;
  const stillray_image* reflection_motion;
} stillray_hits;
#define STILLRAY_HITS_INIT \
  { sizeof(stillray_hits), NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL }

/* Makes guides of reflections from hit distances: see ReflectionsFromHits in docs/library.md. The
 * message is the thread's. INVALID_ARGUMENT: an image is missing or of another size than the depth,
 * or a camera has no perspective; no output is written then. */
STILLRAY_API stillray_error stillray_reflections_from_hits(const stillray_hits* hits);

/* ---- Statistics ------------------------------------------------------------------------------ */

/* Statistics of the last frame. */
typedef struct stillray_statistics {
  size_t struct_size; /* sizeof(stillray_statistics), by the INIT below */
  int64_t non_finite; /* pixels of signals with NaN or infinite light, treated as missing */
  int64_t negative;   /* ... with light below -1/1024 of the mean light; above, it is zero */
  /* pixels whose depth or normal was invalid: passed through; and those with NaN as confidence */
  int64_t bad_guides;
  size_t memory_bytes; /* history and working memory in use */
  double filter_ms;    /* time of all stages, without copying images in and out */
} stillray_statistics;
#define STILLRAY_STATISTICS_INIT \
  { sizeof(stillray_statistics), 0, 0, 0, 0, 0 }
STILLRAY_API stillray_error stillray_denoiser_statistics(stillray_denoiser* denoiser,
                                                         stillray_statistics* statistics);
/* A one-line warning about the last frame, which was denoised nevertheless: normals that are all
 * zero, motion that is nowhere finite. "" if there is none, or denoiser is NULL or busy. Valid
 * until the next call of this function. */
STILLRAY_API const char* stillray_denoiser_warning(stillray_denoiser* denoiser);

#ifdef __cplusplus
}
#endif

#endif /* STILLRAY_STILLRAY_H_ */
