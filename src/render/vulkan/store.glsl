// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Common part of the shaders that write a batch to the images of a frame. Define kListed, the
// binding of the list of pixels, first.
#include "core/shared.h"
#include "render/shared.h"
#include "render/lens_shape_shared.h"
#include "render/vulkan/scene_shared.h"
#include "render/vulkan/trace_shared.h"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = kListed) readonly buffer Listed {
  uint listed_pixels[];
};

layout(push_constant) uniform Push {
  GpuBatch batch;
  float scale;        // 1 / samples
  uint signal_count;  // see GpuFrame
  uint first_signal;  // first of the signals to store
  uint first_image;   // index of the batch's first element in the virtual guides
};

#include "render/vulkan/batch.glsl"

// The pixel of this thread; false if it is outside the image.
bool FindPixel(ivec2 size, out ivec2 pixel) {
  uint number = gl_GlobalInvocationID.x;
  pixel = number < batch.count ? ivec2(PixelOf(number)) : size;
  return pixel.x < size.x && pixel.y < size.y;
}
