// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What textures.comp looks up.
#ifndef STILLRAY_RENDER_GPU_TEXTURES_SHARED_H
#define STILLRAY_RENDER_GPU_TEXTURES_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct TextureLookup {
  vec2 uv;
  uint texture_number;
  uint srgb;
};

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_GPU_TEXTURES_SHARED_H
