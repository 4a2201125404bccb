// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of select_guides.
#ifndef STILLRAY_DENOISE_SELECT_GUIDES_SHARED_H
#define STILLRAY_DENOISE_SELECT_GUIDES_SHARED_H

#ifdef __cplusplus
#include <limits>

#include "core/shared.h"
#endif

SHARED_BEGIN

SHARED_BLOCK(SelectGuidesParameters) {
  float virtual_roughness;  // largest roughness of surfaces that show virtual images
  // Factor of the normals of images, 1 or -1. A pane shows surfaces where they are: with -1 no
  // pixel beside it, which has no transmitted light, is on the same surface.
  float image_normal;
};

// Depth of the sky in a mirror. Reflected sky is light on a surface, and has to be filtered there.
const float kImageOfSky = 1e9f;

// Depth where there is no surface.
#ifdef __cplusplus
const float kNoSurface = std::numeric_limits<float>::infinity();
#else
#define kNoSurface uintBitsToFloat(0x7f800000u)
#endif

// Whether a pixel has virtual guides: its surface is smooth and shows an image. A depth or a
// roughness of NaN shows none.
SHARED_FN bool ShowsImage(float surface_depth, float image_depth, float roughness, float limit) {
  return surface_depth > 0.0f && surface_depth < kImageOfSky && image_depth > 0.0f &&
         roughness >= 0.0f && roughness <= limit;
}

SHARED_FN float ImageDepth(float depth) {
  return min(depth, kImageOfSky);
}

// Whether an albedo of a layer is black: nothing is reflected there, or let through.
SHARED_FN bool HasNoLight(vec3 albedo) {
  return albedo.x <= 0.0f && albedo.y <= 0.0f && albedo.z <= 0.0f;
}

// Whether a squared length is that of a normal: not zero, not infinite, not NaN.
SHARED_FN bool IsNormalLength2(float length2) {
  return length2 > 1e-12f && length2 < 1e12f;
}

// Factor of the albedo by what is seen; white where that is no number.
SHARED_FN float SeenAlbedo(float albedo) {
  return albedo >= 0.0f && albedo < 1e12f ? albedo : 1.0f;
}

SHARED_END

#endif
