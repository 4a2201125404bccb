// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides, the top of the pyramid (one workgroup): downsamples to all levels above the pushed
// one, then fills down to the pushed one.
#define LOCAL_SIZE_X 256
#define LOCAL_SIZE_Y 1
#define CELLS_BINDING 0
#define CELLS_QUALIFIER coherent
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/pyramid_levels.glsl"

// Number of levels for 32768 pixels.
const int kMostLevels = 11;

void WaitForAll() {
  memoryBarrierBuffer();
  barrier();
}

void main() {
  if (!HasWork()) {
    return;
  }
  Level levels[kMostLevels];
  levels[0] = PushedLevel();
  int top = 0;
  while (top + 1 < kMostLevels && (levels[top].size.x > 1 || levels[top].size.y > 1)) {
    levels[top + 1] = Above(levels[top]);
    ++top;
  }
  int lane = int(gl_LocalInvocationIndex);
  for (int i = 1; i <= top; ++i) {
    ivec2 size = levels[i].size;
    for (int c = lane; c < size.x * size.y; c += LOCAL_SIZE_X) {
      DownsampleCell(levels[i - 1], levels[i], ivec2(c % size.x, c / size.x));
    }
    WaitForAll();
  }
  for (int i = top - 1; i >= 0; --i) {
    ivec2 size = levels[i].size;
    for (int c = lane; c < size.x * size.y; c += LOCAL_SIZE_X) {
      FillCell(levels[i], levels[i + 1], ivec2(c % size.x, c / size.x));
    }
    WaitForAll();
  }
}
