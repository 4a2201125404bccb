// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas for reflections with known hit distance: see stillray/reflections.h.
#ifndef STILLRAY_CORE_HIT_DISTANCE_SHARED_H
#define STILLRAY_CORE_HIT_DISTANCE_SHARED_H

#ifdef __cplusplus
#include <limits>

#include "core/shared.h"
#endif

SHARED_BEGIN

// Camera parameters of a frame. Positions p are relative to the image centre, in units of half the
// width, y down.
SHARED_BLOCK(HitCamera) {
  // The ray through p passes through (x, y) = ray (p, 1) at a depth of 1, in any two axes at right
  // angles to the viewing axis.
  float ray_x_x;
  float ray_x_y;
  float ray_x_1;
  float ray_y_x;
  float ray_y_y;
  float ray_y_1;
  // The point visible at p at the depth z was at (x, y) / w one frame ago, (x, y, w) = (p, 1) +
  // move (p, 1, 1 / z): see CameraMotion. The difference from the identity keeps its precision in
  // floats.
  float move_x_x;
  float move_x_y;
  float move_x_1;
  float move_x_z;
  float move_y_x;
  float move_y_y;
  float move_y_1;
  float move_y_z;
  float move_w_x;
  float move_w_y;
  float move_w_1;
  float move_w_z;
  int width;  // of the frame
  int height;
};

// Hit distances from this value on are the sky.
const float kHitOfSky = 1e9f;

// Depth of the virtual image of the sky.
#ifdef __cplusplus
const float kDepthOfSky = std::numeric_limits<float>::infinity();
#else
#define kDepthOfSky uintBitsToFloat(0x7f800000u)
#endif

// Position of a pixel's centre.
SHARED_FN vec2 PlaceOfPixel(HitCamera c, int x, int y) {
  float scale = 2.0f / float(c.width);
  return vec2((float(x) + 0.5f - 0.5f * float(c.width)) * scale,
              (float(y) + 0.5f - 0.5f * float(c.height)) * scale);
}

// Cosine of the angle between the ray through p and the viewing axis.
SHARED_FN float CosineOfRay(HitCamera c, vec2 p) {
  float x = c.ray_x_x * p.x + c.ray_x_y * p.y + c.ray_x_1;
  float y = c.ray_y_x * p.x + c.ray_y_y * p.y + c.ray_y_1;
  return 1.0f / sqrt(1.0f + x * x + y * y);
}

// View-space z of the virtual image: of the point on the pixel's ray at the distance of the camera
// ray plus the reflected ray. 0, no virtual image, if there is no surface or no hit.
SHARED_FN float DepthOfHit(float depth, float hit, float cosine) {
  if (!(depth > 0.0f) || !(depth < kHitOfSky) || !(hit > 0.0f)) {
    return 0.0f;
  }
  return hit >= kHitOfSky ? kDepthOfSky : depth + hit * cosine;
}

// Motion of the virtual image in pixels. Points outside the image if it was behind the camera.
SHARED_FN vec2 MotionOfHit(HitCamera c, vec2 p, float depth) {
  float nearness = depth < kHitOfSky ? 1.0f / depth : 0.0f;
  float x = c.move_x_x * p.x + c.move_x_y * p.y + c.move_x_1 + c.move_x_z * nearness;
  float y = c.move_y_x * p.x + c.move_y_y * p.y + c.move_y_1 + c.move_y_z * nearness;
  float w = c.move_w_x * p.x + c.move_w_y * p.y + c.move_w_1 + c.move_w_z * nearness;
  float unit = 0.5f * float(c.width);
  vec2 motion = vec2((x - p.x * w) * unit, (y - p.y * w) * unit) / (1.0f + w);
  const float kFar = 1e6f;
  bool in_front = 1.0f + w > 0.0f && abs(motion.x) < kFar && abs(motion.y) < kFar;
  return in_front ? motion : vec2(2.0f * float(c.width), 2.0f * float(c.height));
}

SHARED_END

#endif  // STILLRAY_CORE_HIT_DISTANCE_SHARED_H
