// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What all compute shaders of the denoiser know: the parameters of the frame, and what the device
// keeps from frame to frame. C++ and GLSL see the same bytes: members are ints, floats and uints
// alone, which every layout packs alike.
#ifndef STILLRAY_DENOISE_VULKAN_FRAME_SHARED_H
#define STILLRAY_DENOISE_VULKAN_FRAME_SHARED_H

#ifdef __cplusplus
#include <cstdint>

namespace stillray::vulkan {

using uint = uint32_t;
struct FrameParameters {
#else
layout(set = 0, binding = 26, std140) uniform FrameParameters {
#endif
  // Size and input.
  int width;
  int height;
  int signals;
  int lights;          // bit k: light of kind k is given
  int second_moments;  // bit k: and its second moment
  int albedos;         // bit 0 albedo, 1 specular, 2 transmission: given, and light is divided
  int lights_of_0;     // kinds that make up signal 0, ...
  int lights_of_1;
  int lights_of_2;
  int lights_of_3;
  int albedos_of_0;  // albedos whose sum divides signal 0, ...
  int albedos_of_1;
  int albedos_of_2;
  int albedos_of_3;
  int own_albedos;  // as albedos, whether or not light is divided
  int has_samples;
  int has_id;
  int has_emission;
  int has_background;
  int rec601;
  int firefly;         // 0 off, 1 clamp, 2 compress
  int measure_stride;  // every so many pixels are measured
  uint frame;
  // What is remembered.
  int has_history;
  int has_picture;
  int with_compressed;
  int with_behind;
  float feedback_phase;
  // fill_guides
  int has_held;       // guides of the frame before are held
  int guide_colours;  // bit 0 albedo, 1 specular, 2 transmission, 3 emission, 4 background: given
  int pyramid_cells;  // of all levels of the pyramid together
  uint ghost_stamp;   // marks the held guides that this frame rejects
  float shift_x;      // rounding offset of the places of held guides
  float shift_y;
  // reproject, accumulate, limit_history
  float depth_tolerance;
  float min_cosine;
  int test_id;
  int search;
  float alpha_min;
  float alpha_moments;
  int constant_weight;
  int max_history;
  float dead;
  float gain;
  // estimate_variance
  int estimate;  // 0: the wavelet wants no variance
  int of_mean;
  int spatial;
  float short_length;
  float least_evidence;
  float boost;
  // prefilter_variance
  int smooth_variance;
  int square_root;
  float sigma_l;
  float luminance_epsilon;
  float unbounded_below;
  // atrous
  float sigma_n;
  int plane;
  float sigma_z;
  float plane_tolerance;
  float depth_epsilon;
  float max_slope;
  int wavelet_id;
  float noise_ratio;
  float eaw_sigma_l;
  float eaw_sigma_n;
  float eaw_sigma_z;
  int grows;  // what a level fills is a tap of the next
  // keep_mirrors
  int mirror_signals;  // bit s: signal s is mirrored or refracted light
  float mirror_roughness;
  // antialias, fxaa, tonemap
  float taa_alpha;
  int weigh_by_length;
  int fxaa_by_length;
  float display_scale;
  int curve;
  float dither;
  int colour_is_half;  // which output image is given
  int shows;           // a display image is given
};

#ifdef __cplusplus
struct FrameState {
#else
layout(set = 0, binding = 27, std430) buffer FrameState {
#endif
  // Light is stored times a power of two of its signal, chosen so that half precision neither
  // overflows nor underflows; ratio: this frame's over the last frame's.
  float exposure[4];
  float exposure_ratio[4];
  float picture_exposure;
  float picture_ratio;
  float compressed_scale[4];  // luminance that is compressed to 1/2, without exposure; 0: none yet
  float old_compressed_scale[4];
  float mean_luminance[4];  // of accumulated light, without exposure
  // Counts of this frame.
  uint non_finite;
  uint negative;
  uint bad_guides;
  // Results of fill_guides for this frame.
  uint known_pixels;
  uint guides_move;  // not 0: some known pixel moves
};

#ifdef __cplusplus
}  // namespace stillray::vulkan
#endif

#endif
