// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The data of all compute shaders of the denoiser: the parameters of the frame, and the state that
// the device keeps between frames. C++ and GLSL have one layout: members are ints, floats, uints
// and blocks of them (SHARED_BLOCK).
#ifndef STILLRAY_DENOISE_VULKAN_FRAME_SHARED_H
#define STILLRAY_DENOISE_VULKAN_FRAME_SHARED_H

#include "denoise/stages/accumulate_shared.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/atrous_shared.h"
#include "denoise/stages/clip_outliers_shared.h"
#include "denoise/stages/demodulate_shared.h"
#include "denoise/stages/estimate_variance_shared.h"
#include "denoise/stages/fxaa_shared.h"
#include "denoise/stages/keep_mirrors_shared.h"
#include "denoise/stages/keep_samples_shared.h"
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/prefilter_variance_shared.h"
#include "denoise/stages/reproject_shared.h"
#include "denoise/stages/restore_energy_shared.h"
#include "denoise/stages/tonemap_shared.h"

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>

namespace stillray::vulkan {

using uint = uint32_t;
struct FrameParameters {
#else
layout(set = 0, binding = 28, std140) uniform FrameParameters {
#endif
  // Size and input.
  int width;
  int height;
  int signals;
  int lights;          // bit k: radiance of SignalKind k is given
  int second_moments;  // bit k: the second moment of SignalKind k is given
  int albedos;         // bit 0 albedo, 1 specular, 2 transmission: given and used for demodulation
  int lights_of_0;     // bit k: SignalKind k is a term of signal 0, ...
  int lights_of_1;
  int lights_of_2;
  int lights_of_3;
  int albedos_of_0;  // albedos whose sum is the divisor of signal 0, ...
  int albedos_of_1;
  int albedos_of_2;
  int albedos_of_3;
  int by_channel;   // 1: signal c is channel c of the radiance
  int own_albedos;  // as `albedos`, whether or not radiance is demodulated
  int has_samples;
  int has_id;
  int has_emission;
  int has_background;
  int has_confidence;
  int has_previous_normal;
  int measure_stride;  // distance between the measured pixels
  // History.
  int has_history;
  int has_picture;
  int with_compressed;
  int with_behind;
  float feedback_phase;
  // fill_guides
  int has_held;       // guides of the previous frame are held
  int guide_colours;  // bit 0 albedo, 1 specular, 2 transmission, 3 emission, 4 background: given
  int pyramid_cells;  // of all levels of the pyramid together
  uint ghost_stamp;   // marks the held guides that this frame rejects
  float shift_x;      // rounding offset of the positions of held guides
  float shift_y;
  int estimates_variance;  // 0: the wavelet reads no variance
  int colour_is_half;      // which output image is given
  int keeps_length;  // 1: output alpha is the history length of the first signal; 0: alpha is 1
  int shows;         // a display image is given
  RestoreEnergyParameters restore_energy;
  DemodulateParameters demodulate;
  ReprojectParameters reproject;
  LimitHistoryParameters limit_history;
  AtrousParameters compared;
  AccumulateParameters accumulate;
  EstimateVarianceParameters estimate_variance;
  PrefilterVarianceParameters prefilter_variance;
  AtrousParameters atrous;
  ClipOutliersParameters clip_outliers;
  KeepSamplesParameters keep_samples;
  KeepMirrorsParameters keep_mirrors;
  FxaaParameters fxaa;
  AntialiasParameters antialias;
  TonemapParameters tonemap;
};

#ifdef __cplusplus
static_assert(sizeof(EdgeStopping) == 48 && sizeof(AtrousParameters) == 80 &&
                  sizeof(EstimateVarianceParameters) == 80 && sizeof(LimitHistoryParameters) == 32,
              "blocks fill multiples of 16 bytes, as in GLSL");
static_assert(offsetof(FrameParameters, demodulate) % 16 == 0);

struct FrameState {
#else
layout(set = 0, binding = 29, std430) buffer FrameState {
#endif
  // Exposure of each signal: radiance is stored times this power of two, chosen so that half
  // precision neither overflows nor underflows; ratio: this frame's exposure over the last frame's.
  float exposure[4];
  float exposure_ratio[4];
  float picture_exposure;
  float picture_ratio;
  float compressed_scale[4];  // luminance compressed to 1/2, without exposure; 0: none yet
  float old_compressed_scale[4];
  float mean_luminance[4];  // of the accumulated signal, without exposure
  // Counts of this frame, cleared with its parameters.
  uint non_finite;
  uint negative;
  uint bad_guides;
  // Results of fill_guides for this frame.
  uint known_pixels;
  uint guides_move;  // not 0: some known pixel has motion
};

#ifdef __cplusplus
}  // namespace stillray::vulkan
#endif

#endif
