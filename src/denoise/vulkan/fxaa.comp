// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fxaa: see stages/fxaa.h.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/fxaa_shared.h"

layout(set = 1, binding = 0) uniform texture2D picture;
layout(set = 1, binding = 1) uniform texture2DArray moments;
layout(set = 1, binding = 2, LIGHT_FORMAT) writeonly uniform image2D picture_out;

float At(int x, int y) {
  vec3 c = texelFetch(picture, ClampToPicture(ivec2(x, y)), 0).xyz;
  return max(Luminance709(c.x, c.y, c.z), 0.0f);
}

struct Step {
  ivec2 offset;
  float share;
};

Step FindStep(int x, int y) {
  Step none = Step(ivec2(0), 0.0f);
  float m = At(x, y);
  float n = At(x, y - 1);
  float s = At(x, y + 1);
  float w = At(x - 1, y);
  float e = At(x + 1, y);
  if (!IsEdge(min(min(min(m, n), min(s, w)), e), max(max(max(m, n), max(s, w)), e))) {
    return none;
  }
  // Second differences across rows and columns determine the direction of the edge.
  float nw = At(x - 1, y - 1);
  float ne = At(x + 1, y - 1);
  float sw = At(x - 1, y + 1);
  float se = At(x + 1, y + 1);
  float rows = abs(n + s - 2.0f * m) * 2.0f + abs(nw + sw - 2.0f * w) + abs(ne + se - 2.0f * e);
  float columns = abs(w + e - 2.0f * m) * 2.0f + abs(nw + ne - 2.0f * n) + abs(sw + se - 2.0f * s);
  bool along_x = rows >= columns;
  float before = along_x ? n : w;
  float after = along_x ? s : e;
  int side = abs(before - m) >= abs(after - m) ? -1 : 1;
  float other = side < 0 ? before : after;
  float rise = abs(other - m);
  float middle = 0.5f * (other + m);
  ivec2 along = along_x ? ivec2(1, 0) : ivec2(0, 1);
  ivec2 across = along_x ? ivec2(0, side) : ivec2(side, 0);
  int reach[2] = int[2](kFxaaReach, kFxaaReach);
  float end[2] = float[2](0.0f, 0.0f);
  for (int k = 0; k < 2; ++k) {
    for (int d = 1; d <= kFxaaReach; ++d) {
      // Mean of the two rows of the edge: it differs from the middle where the step ends.
      ivec2 here = ivec2(x, y) + along * (k == 0 ? -d : d);
      ivec2 there = here + across;
      float difference = 0.5f * (At(here.x, here.y) + At(there.x, there.y)) - middle;
      if (abs(difference) >= 0.25f * rise) {
        reach[k] = d;
        end[k] = difference;
        break;
      }
    }
  }
  bool first = reach[0] <= reach[1];
  float nearer_end = first ? end[0] : end[1];
  float nearer = float(first ? reach[0] : reach[1]);
  float farther = float(first ? reach[1] : reach[0]);
  // Beyond the nearer end both rows must match the other side, or the edge bends away.
  if (nearer_end == 0.0f || (nearer_end > 0.0f) != (other > m)) {
    return none;
  }
  return Step(across, AcrossShare(nearer - 0.5f, farther - 0.5f));
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  float samples = max(texelFetch(moments, ivec3(p, 0), 0).z, 0.0f);
  float strength = fxaa.fxaa_sparse != 0 ? FxaaStrength(samples) : 1.0f;
  vec4 own = texelFetch(picture, p, 0);
  if (strength > 0.0f) {
    Step found = FindStep(p.x, p.y);
    vec4 other = texelFetch(picture, ClampToPicture(p + found.offset), 0);
    own += strength * found.share * (other - own);
  }
  imageStore(picture_out, p, Stored(own));
}
