// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// prepare_guides: see stages/prepare_guides.h.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/reduce.glsl"
#include "denoise/stages/prepare_guides_shared.h"

layout(set = 1, binding = 0) uniform texture2DArray history;  // radiance of the last frame
layout(set = 1, binding = 1, SURFACE_FORMAT) writeonly uniform uimage2D surface_out;
layout(set = 1, binding = 2, DETAIL_FORMAT) writeonly uniform uimage2D detail_out;
layout(set = 1, binding = 3, SCALAR_FORMAT) writeonly uniform image2DArray turn2_out;
layout(set = 1, binding = 4, std430) writeonly buffer HistorySums {
  vec4 history_sums[];
};

struct Guide {
  Surface surface;
  uint id;
  bool bad;
};

// 1 / z and unit normal where there is a usable surface, else zero.
Guide Convert(ivec2 p) {
  Guide g;
  g.surface = Surface(0.0f, vec3(0.0f));
  g.id = 0u;
  g.bad = false;
  if (!Inside(p)) {
    return g;
  }
  float z = texelFetch(depth_image, p, 0).x;
  vec3 n = texelFetch(normal_image, p, 0).xyz;
  bool finite_normal = IsFinite(n);
  float length2 = dot(n, n);
  bool positive = z > 0.0f && !IsNaN(z);
  g.bad = !positive || !finite_normal;
  if (positive && IsFinite(z) && finite_normal && length2 > 1e-12f && IsFinite(length2)) {
    g.surface = Surface(1.0f / z, n * (1.0f / sqrt(length2)));
    g.id = has_id != 0 ? texelFetch(id_image, p, 0).x : 0u;
  }
  return g;
}

float SameSlope(Guide a, Guide b) {
  bool same = dot(a.surface.normal, b.surface.normal) >= kGradientMinCosine && a.id == b.id;
  return same ? 1.0f : 0.0f;
}

float Slope(Guide before, Guide centre, Guide after) {
  return OneSidedGradient(before.surface.inverse_depth, centre.surface.inverse_depth,
                          after.surface.inverse_depth, SameSlope(centre, before),
                          SameSlope(centre, after));
}

// Sums the history's luminances over the workgroup; update_exposure chooses the compression scale
// for reproject from the sums. Done in this pass, since the history is complete before the frame.
void MeasureHistory(ivec2 p) {
  vec4 luminance = SumOfGroup(LuminancesAt(history, p));
  if (gl_LocalInvocationIndex == 0u) {
    history_sums[GroupIndex()] = luminance;
  }
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (with_compressed != 0 && has_history != 0) {
    MeasureHistory(p);  // before the control flow of invocations diverges
  }
  if (!Inside(p)) {
    return;
  }
  Guide g = Convert(p);
  Guide left = Convert(p - ivec2(1, 0));
  Guide right = Convert(p + ivec2(1, 0));
  Guide above = Convert(p - ivec2(0, 1));
  Guide below = Convert(p + ivec2(0, 1));
  Detail detail;
  detail.gradient = vec2(Slope(left, g, right), Slope(above, g, below));
  detail.id = g.id;
  imageStore(surface_out, p, PackSurface(g.surface));
  imageStore(detail_out, p, PackDetail(detail, g.surface.inverse_depth));
  if (atrous.edges.curvature > 0.0f) {
    vec3 n = g.surface.normal;
    float turn2 = SquaredTurn(dot(n, left.surface.normal), dot(n, right.surface.normal),
                              dot(n, above.surface.normal), dot(n, below.surface.normal));
    imageStore(turn2_out, ivec3(p, 0), Stored(vec4(turn2)));
  }
  bool bad_confidence = has_confidence != 0 && IsNaN(texelFetch(confidence_image, p, 0).x);
  if (g.bad || bad_confidence) {
    atomicAdd(bad_guides, (g.bad ? 1u : 0u) + (bad_confidence ? 1u : 0u));
  }
}
