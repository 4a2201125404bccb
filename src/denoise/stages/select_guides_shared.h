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
  // Factor of the normals of virtual images, 1 or -1. Through a pane, surfaces appear at their true
  // positions: with -1, the pixels beside the pane, which have no transmitted light, do not match
  // them.
  float image_normal;
  // Largest roughness of surfaces whose radiance, filtered with the guides of the surface, is
  // reprojected along the motion of the virtual image.
  float virtual_motion_roughness;
};

// Depth of reflected sky. It must be finite, since reflected sky is radiance of a surface and has
// to be filtered.
const float kImageOfSky = 1e9f;

// Roughness of pixels with virtual guides in the guides of a layer: larger than any real roughness,
// so that keep_mirrors does not treat them as mirrors.
const float kRoughnessOfImage = 2.0f;

// Depth where there is no surface.
#ifdef __cplusplus
const float kNoSurface = std::numeric_limits<float>::infinity();
#else
#define kNoSurface uintBitsToFloat(0x7f800000u)
#endif

// Whether a pixel has virtual guides: its surface is smooth and shows a virtual image. False if the
// depth or the roughness is NaN.
SHARED_FN bool ShowsImage(float surface_depth, float image_depth, float roughness, float limit) {
  return surface_depth > 0.0f && surface_depth < kImageOfSky && image_depth > 0.0f &&
         roughness >= 0.0f && roughness <= limit;
}

// Whether the radiance of a pixel without virtual guides may move with the virtual image: a rough
// surface blurs the reflection, but the blurred image lies behind it too.
SHARED_FN bool MayMoveWithImage(float surface_depth, float image_depth, float roughness,
                                float shows_limit, float moves_limit) {
  return ShowsImage(surface_depth, image_depth, roughness, moves_limit) &&
         !(roughness <= shows_limit);
}

// The motion (virtual image minus surface) is the mean over those of 3x3 pixels at this distance
// that lie on the same reflector, since the lobe of a rough surface covers the reflections of
// several.
const int kReflectorStep = 3;
// Squared cosine of the normals of one reflector.
const float kSameReflector2 = 0.64f;

SHARED_FN bool IsSameReflector(vec3 normal, uint id, vec3 other_normal, uint other_id) {
  float cosine = dot(normal, other_normal);
  float lengths2 = dot(normal, normal) * dot(other_normal, other_normal);
  return id == other_id && cosine > 0.0f && cosine * cosine >= kSameReflector2 * lengths2;
}

// Longest valid motion, in pixels; longer ones belong to virtual images that were not visible
// before.
const float kMostImageMotion = 64.0f;

// Adds a motion to (sum x, sum y, sum of squares, count) if it is known.
SHARED_FN vec4 AddImageMotion(vec4 sums, vec2 motion) {
  float square = dot(motion, motion);
  return square <= kMostImageMotion * kMostImageMotion
             ? sums + vec4(motion.x, motion.y, square, 1.0f)
             : sums;
}

SHARED_FN vec2 MeanImageMotion(vec4 sums) {
  return vec2(sums.x, sums.y) / max(sums.w, 1.0f);
}

// Largest standard deviation of the motions of one virtual image, in pixels and relative to their
// mean. On a curved, detailed surface each pixel reflects another surface.
const float kAlikePixels = 0.1f;
const float kAlikePart = 0.3f;

SHARED_FN bool AreMotionsAlike(vec4 sums) {
  vec2 mean = MeanImageMotion(sums);
  float mean2 = dot(mean, mean);
  float variance = max(sums.z / max(sums.w, 1.0f) - mean2, 0.0f);
  return sums.w > 0.0f && sqrt(variance) <= kAlikePixels + kAlikePart * sqrt(mean2);
}

// Whether the pixel at this offset, on the same reflector, has nearly the depth of the pixel
// itself, since reproject compares the depth of a history with that of the pixel. For offsets up to
// one pixel, reproject's tolerance for slopes is enough.
const float kReflectorDepth = 0.03f;
SHARED_FN bool IsAtSameDepth(float depth, float other_depth, vec2 offset) {
  return max(abs(offset.x), abs(offset.y)) <= 1.0f ||
         abs(other_depth - depth) <= kReflectorDepth * depth;
}

SHARED_FN float ImageDepth(float depth) {
  return min(depth, kImageOfSky);
}

// Whether the albedo of a layer is black: nothing is reflected or transmitted.
SHARED_FN bool HasNoLight(vec3 albedo) {
  return albedo.x <= 0.0f && albedo.y <= 0.0f && albedo.z <= 0.0f;
}

// Whether a squared length is valid for a normal: not zero, infinite or NaN.
SHARED_FN bool IsNormalLength2(float length2) {
  return length2 > 1e-12f && length2 < 1e12f;
}

// Albedo of the reflected or refracted surface, as a factor; 1 if it is invalid.
SHARED_FN float SeenAlbedo(float albedo) {
  return albedo >= 0.0f && albedo < 1e12f ? albedo : 1.0f;
}

SHARED_END

#endif
