// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Writes the light of a batch into the images of a frame: StoreLight and SparseFrameWriter on the
// device. With STILLRAY_MOMENTS also second moments, with STILLRAY_LISTED one sample for each
// pixel.
#ifdef STILLRAY_MOMENTS
#define kImages 8
#elif defined(STILLRAY_LISTED)
#define kImages 5
#else
#define kImages 4
#endif
#define kListed (kImages + 1)
#include "render/vulkan/store.glsl"

layout(set = 0, binding = 0, rgba32f) writeonly uniform image2D light_0;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D light_1;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D light_2;
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D light_3;
#ifdef STILLRAY_MOMENTS
layout(set = 0, binding = 4, r32f) writeonly uniform image2D moment_0;
layout(set = 0, binding = 5, r32f) writeonly uniform image2D moment_1;
layout(set = 0, binding = 6, r32f) writeonly uniform image2D moment_2;
layout(set = 0, binding = 7, r32f) writeonly uniform image2D moment_3;
#elif defined(STILLRAY_LISTED)
layout(set = 0, binding = 4, r32f) writeonly uniform image2D samples;
#endif
layout(std430, set = 0, binding = kImages) readonly buffer Sums {
  GpuPixelLight sums[];
};

void main() {
  ivec2 pixel;
  if (!FindPixel(imageSize(light_0), pixel)) {
    return;
  }
  GpuPixelLight sum = sums[gl_GlobalInvocationID.x];
  imageStore(light_0, pixel, vec4(sum.signals[0].light * scale, 0.0f));
  imageStore(light_1, pixel, vec4(sum.signals[1].light * scale, 0.0f));
  imageStore(light_2, pixel, vec4(sum.signals[2].light * scale, 0.0f));
  imageStore(light_3, pixel, vec4(sum.signals[3].light * scale, 0.0f));
#ifdef STILLRAY_MOMENTS
  imageStore(moment_0, pixel, vec4(sum.signals[0].square * scale));
  imageStore(moment_1, pixel, vec4(sum.signals[1].square * scale));
  imageStore(moment_2, pixel, vec4(sum.signals[2].square * scale));
  imageStore(moment_3, pixel, vec4(sum.signals[3].square * scale));
#elif defined(STILLRAY_LISTED)
  imageStore(samples, pixel, vec4(1.0f));
#endif
}
