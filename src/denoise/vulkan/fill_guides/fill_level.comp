// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides: fills the holes of the pushed level from the level above. One invocation per cell.
#define CELLS_BINDING 0
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/pyramid_levels.glsl"

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  Level level = PushedLevel();
  if (HasWork() && Covers(level, p)) {
    FillCell(level, Above(level), p);
  }
}
