// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Limits for the surfaces that a camera ray passes.
#ifndef STILLRAY_RENDER_PRIMARY_SHARED_H
#define STILLRAY_RENDER_PRIMARY_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// A ray that passes more surfaces than this, all cut out by their masks, hits the background.
const int kMaxPasses = 256;
// Maximum number of layers of a pixel; the last one takes the remaining weight.
const int kMaxLayers = 8;

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_PRIMARY_SHARED_H
