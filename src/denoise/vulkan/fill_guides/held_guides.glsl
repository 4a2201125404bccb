// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Known pixels of a frame, and lookup of held guides: see denoise/fill_guides/held_guides.h.
#include "denoise/fill_guides/fill_guides_shared.h"

bool IsKnown(ivec2 p) {
  // Tests the bits: a NaN depth counts as known, so that it is reported as invalid.
  bool has_depth = (floatBitsToUint(texelFetch(depth_image, p, 0).x) & 0x7fffffffu) != 0u;
  float given = GivenSamples(p);
  return has_depth || (given > 0.0f && !IsNaN(given));
}

bool IsSurface(float depth) {
  return depth > 0.0f && IsFinite(depth);
}

bool IsMoving(float motion) {
  return IsNaN(motion) || abs(motion) > kMinMotion;
}

// Whether held guides are fetched along the motion.
bool ViewMoves() {
  return has_held != 0 && guides_move != 0u;
}

// Finds the pixel of the previous frame with the surface of p. Returns false if it is outside the
// image.
bool FindHeld(ivec2 p, vec2 motion, out ivec2 q) {
  q = p;
  if (!ViewMoves()) {
    return has_held != 0;
  }
  vec2 place = vec2(HeldCoordinate(p.x, motion.x, shift_x), HeldCoordinate(p.y, motion.y, shift_y));
  bool inside = place.x >= 0.0f && place.y >= 0.0f && place.x < float(width) &&
                place.y < float(height) && !IsNaN(place.x) && !IsNaN(place.y);
  q = inside ? ivec2(place) : p;
  return inside;
}
