// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Parameters of atrous. Its weights: edge_stopping_shared.h.
#ifndef STILLRAY_DENOISE_ATROUS_SHARED_H
#define STILLRAY_DENOISE_ATROUS_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

#include "denoise/stages/edge_stopping_shared.h"

SHARED_BEGIN

// Which edge-stopping functions weigh a tap, beside the kernel.
const int kAtrousNaive = 0;     // none
const int kAtrousGeometry = 1;  // normal and depth
const int kAtrousSvgf = 2;      // normal, depth and luminance against the local spread
const int kAtrousEaw = 3;       // Gaussians of luminance, normal and depth differences

// What a level writes on the device.
const int kAtrousLight = 0;  // the filtered signal, input of the next level
const int kAtrousSums = 1;   // the sums of weights, as an output image
const int kAtrousPilot = 2;  // the pilot estimate: the filtered signal, mixed with the input

// Variants of the weights that are specialization constants of the device's pipelines, as bits.
#define STILLRAY_ATROUS_CURVED 1     // curvature is on
#define STILLRAY_ATROUS_PLANES 2     // depth_weight_plane
#define STILLRAY_ATROUS_IDS 4        // wavelet_id
#define STILLRAY_ATROUS_POSITIONS 8  // depth_weight_position

SHARED_BLOCK(AtrousParameters) {
  EdgeStopping edges;
  int wavelet_id;     // 1: also stop at another id, except with kAtrousGeometry
  float noise_ratio;  // >= 1; see SharedLuminanceFactor
  float eaw_sigma_l;  // in mean luminances of the signal
  float eaw_sigma_n;
  float eaw_sigma_z;
  int grows;              // 1: pixels that a level fills are taps of the next level
  int reflected_signals;  // bit s: signal s is specular (kLeastReflectedSigmaN)
};

SHARED_END

#endif
