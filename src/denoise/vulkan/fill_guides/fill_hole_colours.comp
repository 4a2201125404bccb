// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// fill_guides, FillHoles for albedos, emission and background: emission on surfaces only,
// background in the sky only.
#define CELLS_BINDING 6
#define COLOURS_BINDING 1
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fill_guides/pyramid.glsl"
#include "denoise/vulkan/fill_guides/colour_images.glsl"

layout(set = 1, binding = 0) uniform texture2D normal_now;  // w: known

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p) || texelFetch(normal_now, p, 0).w != 0.0f) {
    return;
  }
  bool is_surface = HoleAt(p).is_surface;
  for (int k = 0; k < kColourCount; ++k) {
    if (HasColour(k)) {
      bool zero = (k == kEmission && !is_surface) || (k == kBackground && is_surface);
      StoreColour(k, p, zero ? vec3(0.0f) : Upsample(FirstLevel(), ColourLayer(k), p));
    }
  }
}
