// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Writes the virtual guides of a batch to the images of a frame: StoreVirtualImages on the device.
#define kImages 5
#define kListed (kImages + 1)
#include "render/vulkan/store.glsl"

layout(set = 0, binding = 0, r32f) writeonly uniform image2D depth;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D normal;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D albedo;
layout(set = 0, binding = 3, rg32f) writeonly uniform image2D motion;
layout(set = 0, binding = 4, r32ui) writeonly uniform uimage2D id;
layout(std430, set = 0, binding = kImages) readonly buffer Images {
  GpuImage images[];
};

void main() {
  ivec2 pixel;
  if (!FindPixel(imageSize(depth), pixel)) {
    return;
  }
  GpuImage image = images[first_image + gl_GlobalInvocationID.x];
  imageStore(depth, pixel, vec4(image.depth));
  imageStore(normal, pixel, vec4(image.normal, 0.0f));
  imageStore(albedo, pixel, vec4(image.albedo, 0.0f));
  imageStore(motion, pixel, vec4(image.motion_x, image.motion_y, 0.0f, 0.0f));
  imageStore(id, pixel, uvec4(image.id));
}
