// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides, GatherKnown for albedos, emission and background, from the pixels whose geometry
// gather_known has copied; downsampled to the first level. One invocation per cell.
#define CELLS_BINDING 13
#define COLOURS_BINDING 8
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/held_guides.glsl"
#include "denoise/vulkan/fill_guides/pyramid.glsl"
#include "denoise/vulkan/fill_guides/colour_images.glsl"

layout(set = 1, binding = 0) uniform texture2D depth_now;
layout(set = 1, binding = 1) uniform texture2D normal_now;  // w: known
layout(set = 1, binding = 2) uniform texture2D motion_now;
layout(set = 1, binding = 3) uniform texture2D albedo_before;
layout(set = 1, binding = 4) uniform texture2D specular_before;
layout(set = 1, binding = 5) uniform texture2D through_before;
layout(set = 1, binding = 6) uniform texture2D emission_before;
layout(set = 1, binding = 7) uniform texture2D background_before;

vec3 FromFrame(int k, ivec2 p) {
  return k == 0   ? texelFetch(albedo_image, p, 0).xyz
         : k == 1 ? texelFetch(specular_albedo_image, p, 0).xyz
         : k == 2 ? texelFetch(transmission_albedo_image, p, 0).xyz
         : k == 3 ? texelFetch(emission_image, p, 0).xyz
                  : texelFetch(background_image, p, 0).xyz;
}

vec3 FromBefore(int k, ivec2 q) {
  return k == 0   ? texelFetch(albedo_before, q, 0).xyz
         : k == 1 ? texelFetch(specular_before, q, 0).xyz
         : k == 2 ? texelFetch(through_before, q, 0).xyz
         : k == 3 ? texelFetch(emission_before, q, 0).xyz
                  : texelFetch(background_before, q, 0).xyz;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  Level level = FirstLevel();
  if (!Covers(level, p)) {
    return;
  }
  Mean mean[kColourCount];
  for (int k = 0; k < kColourCount; ++k) {
    mean[k] = NoMean();
  }
  for (int i = 0; i < kPyramidFactor * kPyramidFactor; ++i) {
    int column = i % kPyramidFactor;
    ivec2 q = p * kPyramidFactor + ivec2(column, i / kPyramidFactor);
    if (!Inside(q) || texelFetch(normal_now, q, 0).w == 0.0f) {
      continue;  // fill_hole_colours writes holes
    }
    bool is_new = IsKnown(q);
    ivec2 from = q;
    if (!is_new) {
      FindHeld(q, texelFetch(motion_now, q, 0).xy, from);
    }
    uint kind = IsSurface(texelFetch(depth_now, q, 0).x) ? kOfSurface : kOfSky;
    for (int k = 0; k < kColourCount; ++k) {
      if (HasColour(k)) {
        vec3 value = is_new ? FromFrame(k, q) : FromBefore(k, from);
        StoreColour(k, q, value);
        if (KindOfColour(k) == kind) {
          Add(mean[k], column, value);
        }
      }
    }
  }
  for (int k = 0; k < kColourCount; ++k) {
    if (HasColour(k)) {
      StoreCell(level, ColourLayer(k), p, ValueOf(mean[k]), 0u);
    }
  }
}
