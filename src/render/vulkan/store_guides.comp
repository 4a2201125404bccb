// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Writes the guides of a batch to the images of a frame: StoreGuides on the device. Variants keep
// the number of storage images within eight, the least that devices may support: colours
// (STILLRAY_COLOURS), previous normals, present only if instances may rotate
// (STILLRAY_PREVIOUS_NORMALS), the albedo of transmitted light (STILLRAY_TRANSMISSION), and the
// other images.
#if defined(STILLRAY_COLOURS)
#define kImages 4
#elif defined(STILLRAY_TRANSMISSION)
#define kImages 1
#elif defined(STILLRAY_PREVIOUS_NORMALS)
#define kImages 1
#else
#define kImages 5
#endif
#define kListed (kImages + 1)
#include "render/vulkan/store.glsl"
#include "render/geometry_shared.h"
#include "render/previous_normal_shared.h"

#if defined(STILLRAY_COLOURS)
layout(set = 0, binding = 0, rgba32f) writeonly uniform image2D albedo;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D specular_albedo;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D emission;
layout(set = 0, binding = 3, rgba32f) writeonly uniform image2D background;
#elif defined(STILLRAY_TRANSMISSION)
layout(set = 0, binding = 0, rgba32f) writeonly uniform image2D transmission_albedo;
#elif defined(STILLRAY_PREVIOUS_NORMALS)
layout(set = 0, binding = 0, rgba32f) writeonly uniform image2D previous_normal;
layout(std430, set = 0, binding = kListed + 1) readonly buffer Instances {
  GpuInstance instances[];
};
#else
layout(set = 0, binding = 0, r32f) writeonly uniform image2D depth;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D normal;
layout(set = 0, binding = 2, rg32f) writeonly uniform image2D motion;
layout(set = 0, binding = 3, r32ui) writeonly uniform uimage2D id;
layout(set = 0, binding = 4, r32f) writeonly uniform image2D roughness;
#endif
layout(std430, set = 0, binding = kImages) readonly buffer Guides {
  GpuGuides guides[];
};

#ifdef STILLRAY_PREVIOUS_NORMALS
vec3 PreviousNormalOf(GpuGuides of) {
  if (of.id == 0u) {
    return vec3(0.0f);
  }
  GpuInstance i = instances[of.id - 1u];
  if (HasChangedShape(i)) {
    return of.previous_normal;
  }
  return PreviousNormal(LinearRows(i.world_x.xyz, i.world_y.xyz, i.world_z.xyz),
                        LinearRows(i.previous_x.xyz, i.previous_y.xyz, i.previous_z.xyz),
                        of.normal);
}
#endif

void main() {
  ivec2 pixel;
  uint number = gl_GlobalInvocationID.x;
#if defined(STILLRAY_COLOURS)
  if (FindPixel(imageSize(albedo), pixel)) {
    imageStore(albedo, pixel, vec4(guides[number].albedo, 0.0f));
    imageStore(specular_albedo, pixel, vec4(guides[number].specular_albedo, 0.0f));
    imageStore(emission, pixel, vec4(guides[number].emission, 0.0f));
    imageStore(background, pixel, vec4(guides[number].background, 0.0f));
  }
#elif defined(STILLRAY_TRANSMISSION)
  if (FindPixel(imageSize(transmission_albedo), pixel)) {
    imageStore(transmission_albedo, pixel, vec4(guides[number].transmission_albedo, 0.0f));
  }
#elif defined(STILLRAY_PREVIOUS_NORMALS)
  if (FindPixel(imageSize(previous_normal), pixel)) {
    imageStore(previous_normal, pixel, vec4(PreviousNormalOf(guides[number]), 0.0f));
  }
#else
  if (FindPixel(imageSize(depth), pixel)) {
    imageStore(depth, pixel, vec4(guides[number].depth));
    imageStore(normal, pixel, vec4(guides[number].normal, 0.0f));
    imageStore(motion, pixel, vec4(guides[number].motion_x, guides[number].motion_y, 0.0f, 0.0f));
    imageStore(id, pixel, uvec4(guides[number].id));
    imageStore(roughness, pixel, vec4(guides[number].roughness));
  }
#endif
}
