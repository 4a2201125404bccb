// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Parameters of how light becomes signals and signals light.
#ifndef STILLRAY_DENOISE_DEMODULATE_SHARED_H
#define STILLRAY_DENOISE_DEMODULATE_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(DemodulateParameters) {
  int demodulate;        // 1: light is divided by its albedo
  int luminance_rec601;  // 1: luminance weights of Rec. 601, 0: of Rec. 709
  int firefly;           // 0 off, 1 clamp, 2 compress
};

SHARED_END

#endif
