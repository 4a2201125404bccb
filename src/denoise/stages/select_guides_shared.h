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
  // Largest roughness of surfaces whose light, reprojected by guides of the surface, moves with the
  // image.
  float virtual_motion_roughness;
};

// Depth of the sky in a mirror. Reflected sky is light on a surface, and has to be filtered there.
const float kImageOfSky = 1e9f;

// Roughness of pixels with virtual guides in the guides of a layer: larger than that of any
// surface, so that they are no mirrors for keep_mirrors, which leaves them alone.
const float kRoughnessOfImage = 2.0f;

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

// Whether the light of a pixel, which shows no image, may move as the image does: a rough surface
// blurs what it reflects, but the blurred image lies behind it too.
SHARED_FN bool MayMoveWithImage(float surface_depth, float image_depth, float roughness,
                                float shows_limit, float moves_limit) {
  return ShowsImage(surface_depth, image_depth, roughness, moves_limit) &&
         !(roughness <= shows_limit);
}

// The motion is that of the mean over 3x3 pixels at this distance, since a rough surface reflects
// what several of them see: image less surface, as far as they show the same reflector.
const int kReflectorStep = 3;
// Squared cosine of the normals of one reflector.
const float kSameReflector2 = 0.64f;

SHARED_FN bool IsSameReflector(vec3 normal, uint id, vec3 other_normal, uint other_id) {
  float cosine = dot(normal, other_normal);
  float lengths2 = dot(normal, normal) * dot(other_normal, other_normal);
  return id == other_id && cosine > 0.0f && cosine * cosine >= kSameReflector2 * lengths2;
}

// Longer ones, in pixels, are of images that were not in sight.
const float kMostImageMotion = 64.0f;

// Adds a motion to (sum, sum of squares, count), unless it is not known.
SHARED_FN vec4 AddImageMotion(vec4 sums, vec2 motion) {
  float square = dot(motion, motion);
  return square <= kMostImageMotion * kMostImageMotion
             ? sums + vec4(motion.x, motion.y, square, 1.0f)
             : sums;
}

SHARED_FN vec2 MeanImageMotion(vec4 sums) {
  return vec2(sums.x, sums.y) / max(sums.w, 1.0f);
}

// Standard deviation of the motions, in pixels and relative to their mean, up to which they are
// those of one image. On a curved, detailed surface each pixel reflects something else.
const float kAlikePixels = 0.1f;
const float kAlikePart = 0.3f;

SHARED_FN bool AreMotionsAlike(vec4 sums) {
  vec2 mean = MeanImageMotion(sums);
  float mean2 = dot(mean, mean);
  float variance = max(sums.z / max(sums.w, 1.0f) - mean2, 0.0f);
  return sums.w > 0.0f && sqrt(variance) <= kAlikePixels + kAlikePart * sqrt(mean2);
}

// Whether a pixel at this offset, on the same reflector, is at nearly the depth of the pixel
// itself: reproject compares the depth of a history with that of the pixel. Its tolerance for
// slopes is enough for one pixel.
const float kReflectorDepth = 0.03f;
SHARED_FN bool IsAtSameDepth(float depth, float other_depth, vec2 offset) {
  return max(abs(offset.x), abs(offset.y)) <= 1.0f ||
         abs(other_depth - depth) <= kReflectorDepth * depth;
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
