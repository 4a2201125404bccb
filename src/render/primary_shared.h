// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Limits on the surfaces along a primary ray.
#ifndef STILLRAY_RENDER_PRIMARY_SHARED_H
#define STILLRAY_RENDER_PRIMARY_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Maximum number of alpha cut-outs along a primary ray; beyond it the ray hits the background.
const int kMaxPasses = 256;
// Maximum number of layers of a pixel; the last layer receives the remaining weight.
const int kMaxLayers = 8;

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_PRIMARY_SHARED_H
