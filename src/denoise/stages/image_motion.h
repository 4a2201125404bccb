// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Part of select_guides: the motion of reflections on rough surfaces. All CPU versions share this
/// scalar code, since few pixels need it and each reads its neighbours.
#pragma once

#include "denoise/stages/select_guides.h"

namespace stillray {

/// A pixel of the surface.
struct ReflectorPixel {
  vec3 normal;
  uint32_t id;
  float depth;
};

inline ReflectorPixel ReflectorAt(const Guides& surface, int x, int y) {
  return {{surface.normal[0](x, y), surface.normal[1](x, y), surface.normal[2](x, y)},
          surface.id.empty() ? 0u : surface.id(x, y),
          surface.depth(x, y)};
}

inline bool IsSameReflector(const ReflectorPixel& a, const ReflectorPixel& b) {
  return IsSameReflector(a.normal, a.id, b.normal, b.id);
}

/// Sums the motions of the reflected image minus those of the surface, over 3x3 pixels of one
/// reflector (AddImageMotion).
inline vec4 SumImageMotions(const SelectGuidesInput& in, const ReflectorPixel& own, int x, int y) {
  const Guides& surface = *in.surface;
  vec4 sums(0.0f);
  for (int v = y - kReflectorStep; v <= y + kReflectorStep; v += kReflectorStep) {
    for (int u = x - kReflectorStep; u <= x + kReflectorStep; u += kReflectorStep) {
      const bool inside =
          u >= 0 && v >= 0 && u < surface.depth.width() && v < surface.depth.height();
      if (inside && in.image->depth(u, v) > 0 && IsSameReflector(own, ReflectorAt(surface, u, v))) {
        sums = AddImageMotion(sums, {in.image->motion[0](u, v) - surface.motion[0](u, v),
                                     in.image->motion[1](u, v) - surface.motion[1](u, v)});
      }
    }
  }
  return sums;
}

/// The motion of the reflection minus that of the surface, at a pixel for which MayMoveWithImage is
/// true; 0 if the reflected images around it move differently, or if the history would not be on
/// the same reflector. Surface and image must have motion planes.
inline vec2 ImageMotionOnSurface(const SelectGuidesInput& in, int x, int y) {
  const Guides& surface = *in.surface;
  const ReflectorPixel own = ReflectorAt(surface, x, y);
  const vec4 sums = SumImageMotions(in, own, x, y);
  if (!AreMotionsAlike(sums)) {
    return vec2(0.0f);
  }
  const vec2 offset = MeanImageMotion(sums);
  const vec2 nearest = floor(offset + 0.5f);
  const int u = x + static_cast<int>(nearest.x);
  const int v = y + static_cast<int>(nearest.y);
  if (u < 0 || v < 0 || u >= surface.depth.width() || v >= surface.depth.height()) {
    return vec2(0.0f);
  }
  const ReflectorPixel there = ReflectorAt(surface, u, v);
  const bool same = IsSameReflector(own, there) && IsAtSameDepth(own.depth, there.depth, offset);
  return same ? offset : vec2(0.0f);
}

}  // namespace stillray
