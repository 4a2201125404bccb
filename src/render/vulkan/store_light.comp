// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Writes two signals of a batch to the images of a frame: StoreLight and SparseFrameWriter on the
// device. STILLRAY_MOMENTS adds second moments, STILLRAY_LISTED a sample count of one per pixel.
#ifdef STILLRAY_MOMENTS
#define kImages 4
#elif defined(STILLRAY_LISTED)
#define kImages 3
#else
#define kImages 2
#endif
#define kListed (kImages + 1)
#include "render/vulkan/store.glsl"

layout(set = 0, binding = 0, rgba32f) writeonly uniform image2D light_0;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D light_1;
#ifdef STILLRAY_MOMENTS
layout(set = 0, binding = 2, r32f) writeonly uniform image2D moment_0;
layout(set = 0, binding = 3, r32f) writeonly uniform image2D moment_1;
#elif defined(STILLRAY_LISTED)
layout(set = 0, binding = 2, r32f) writeonly uniform image2D samples;
#endif
layout(std430, set = 0, binding = kImages) readonly buffer Sums {
  GpuSignal sums[];
};

void main() {
  ivec2 pixel;
  if (!FindPixel(imageSize(light_0), pixel)) {
    return;
  }
  uint first = gl_GlobalInvocationID.x * signal_count + first_signal;
  imageStore(light_0, pixel, vec4(sums[first].light * scale, 0.0f));
  imageStore(light_1, pixel, vec4(sums[first + 1u].light * scale, 0.0f));
#ifdef STILLRAY_MOMENTS
  imageStore(moment_0, pixel, vec4(sums[first].square * scale));
  imageStore(moment_1, pixel, vec4(sums[first + 1u].square * scale));
#elif defined(STILLRAY_LISTED)
  imageStore(samples, pixel, vec4(1.0f));
#endif
}
