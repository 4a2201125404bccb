// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The shape of a lens's aperture.
#ifndef STILLRAY_RENDER_LENS_SHAPE_SHARED_H
#define STILLRAY_RENDER_LENS_SHAPE_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct LensShape {
  int blades;      // corners of the aperture; 0: round
  float rotation;  // angle of the first corner, anticlockwise from the x axis, in turns: [0, 1)
  int mask_width;  // 0: no mask
  int mask_height;
};

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LENS_SHAPE_SHARED_H
