// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Bounds of what a camera ray passes.
#ifndef STILLRAY_RENDER_PRIMARY_SHARED_H
#define STILLRAY_RENDER_PRIMARY_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

// A ray that passes more surfaces than these, all cut out by their masks, sees the background.
const int kMaxPasses = 256;
// Surfaces of a pixel that are kept apart; the last one takes all light that is left.
const int kMaxLayers = 8;

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_PRIMARY_SHARED_H
