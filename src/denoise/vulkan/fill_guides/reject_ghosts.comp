// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides, RejectGhosts: where a known pixel contradicts the held guides at its position, the
// held guides of their surface around it are marked as rejected.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/held_guides.glsl"

layout(set = 1, binding = 0) uniform texture2D depth_before;
layout(set = 1, binding = 1) uniform texture2D normal_before;  // w: known
layout(set = 1, binding = 2) uniform utexture2D id_before;
layout(set = 1, binding = 4, std430) writeonly buffer Rejected {
  uint rejected[];  // by pixel: stamp of the last frame that rejected it
};

struct Seen {
  float depth;
  uint id;
};

bool AreDifferentSurfaces(Seen a, Seen b) {
  if (IsSurface(a.depth) != IsSurface(b.depth)) {
    return true;
  }
  return has_id != 0 ? a.id != b.id : IsSurface(a.depth) && DepthsDiffer(a.depth, b.depth);
}

Seen Before(ivec2 q) {
  return Seen(texelFetch(depth_before, q, 0).x, has_id != 0 ? texelFetch(id_before, q, 0).x : 0u);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  ivec2 q;
  if (!ViewMoves() || !Inside(p) || !IsKnown(p) ||
      !FindHeld(p, texelFetch(motion_image, p, 0).xy, q) ||
      texelFetch(normal_before, q, 0).w == 0.0f) {
    return;
  }
  Seen now = Seen(texelFetch(depth_image, p, 0).x, has_id != 0 ? texelFetch(id_image, p, 0).x : 0u);
  Seen ghost = Before(q);
  if (!AreDifferentSurfaces(now, ghost)) {
    return;
  }
  int radius = GhostRadius(float(known_pixels), float(width) * float(height));
  ivec2 first = max(q - radius, ivec2(0));
  ivec2 last = min(q + radius, Size() - 1);
  for (int y = first.y; y <= last.y; ++y) {
    for (int x = first.x; x <= last.x; ++x) {
      if (!AreDifferentSurfaces(Before(ivec2(x, y)), ghost)) {
        rejected[y * width + x] = ghost_stamp;
      }
    }
  }
}
