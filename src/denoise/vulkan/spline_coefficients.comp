// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// spline_coefficients: see stages/spline_coefficients.h. Each workgroup filters its pixels and
// those around them in shared memory, first along columns, then along rows.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/spline_coefficients_shared.h"

layout(set = 1, binding = 0) uniform texture2D picture;
layout(set = 1, binding = 1, LIGHT_FORMAT) writeonly uniform image2DArray coefficients_out;

const int kTileWidth = LOCAL_SIZE_X + 2 * kSplineRadius;
const int kTileHeight = LOCAL_SIZE_Y + 2 * kSplineRadius;
const int kGroupSize = LOCAL_SIZE_X * LOCAL_SIZE_Y;

shared vec3 tile[kTileHeight][kTileWidth];
shared vec3 columns[LOCAL_SIZE_Y][kTileWidth];

void main() {
  int thread = int(gl_LocalInvocationIndex);
  ivec2 first = ivec2(gl_WorkGroupID.xy) * ivec2(LOCAL_SIZE_X, LOCAL_SIZE_Y) - ivec2(kSplineRadius);
  for (int i = thread; i < kTileWidth * kTileHeight; i += kGroupSize) {
    ivec2 at = ivec2(i % kTileWidth, i / kTileWidth);
    tile[at.y][at.x] = texelFetch(picture, ClampToPicture(first + at), 0).xyz;
  }
  barrier();
  for (int i = thread; i < kTileWidth * LOCAL_SIZE_Y; i += kGroupSize) {
    int x = i % kTileWidth;
    int y = i / kTileWidth + kSplineRadius;
    columns[y - kSplineRadius][x] = kSplineWeight0 * tile[y][x] +
                                    kSplineWeight1 * (tile[y - 1][x] + tile[y + 1][x]) +
                                    kSplineWeight2 * (tile[y - 2][x] + tile[y + 2][x]) +
                                    kSplineWeight3 * (tile[y - 3][x] + tile[y + 3][x]) +
                                    kSplineWeight4 * (tile[y - 4][x] + tile[y + 4][x]);
  }
  barrier();
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  int y = int(gl_LocalInvocationID.y);
  int x = int(gl_LocalInvocationID.x) + kSplineRadius;
  vec3 sum = kSplineWeight0 * columns[y][x] +
             kSplineWeight1 * (columns[y][x - 1] + columns[y][x + 1]) +
             kSplineWeight2 * (columns[y][x - 2] + columns[y][x + 2]) +
             kSplineWeight3 * (columns[y][x - 3] + columns[y][x + 3]) +
             kSplineWeight4 * (columns[y][x - 4] + columns[y][x + 4]);
  imageStore(coefficients_out, ivec3(p, 0), Stored(vec4(sum, 1.0f)));
}
