// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Resamples the guides and the antialiased images of the last frame to the size of this frame:
// guides by nearest neighbour, images bilinearly.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/resample.glsl"

layout(set = 1, binding = 0) uniform utexture2D surface_before;
layout(set = 1, binding = 1) uniform utexture2D detail_before;
layout(set = 1, binding = 2) uniform texture2D picture_before;
layout(set = 1, binding = 3) uniform texture2D albedo_before;
layout(set = 1, binding = 4, SURFACE_FORMAT) writeonly uniform uimage2D surface_out;
layout(set = 1, binding = 5, DETAIL_FORMAT) writeonly uniform uimage2D detail_out;
layout(set = 1, binding = 6, LIGHT_FORMAT) writeonly uniform image2D picture_out;
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2D albedo_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  ivec2 nearest = NearestBefore(p);
  uvec4 surface = texelFetch(surface_before, nearest, 0);
  float inverse_depth = UnpackSurface(surface).inverse_depth;
  Detail detail = UnpackDetail(texelFetch(detail_before, nearest, 0), inverse_depth);
  detail.gradient *= vec2(size_before) / vec2(Size());  // per pixel
  imageStore(surface_out, p, surface);
  imageStore(detail_out, p, PackDetail(detail, inverse_depth));
  PixelsBefore pixels = AroundBefore(p);
  vec4 picture = vec4(0.0f);
  vec4 albedo = vec4(0.0f);
  for (int i = 0; i < 4; ++i) {
    picture += pixels.weight[i] * texelFetch(picture_before, pixels.at[i], 0);
    albedo += pixels.weight[i] * texelFetch(albedo_before, pixels.at[i], 0);
  }
  imageStore(picture_out, p, Stored(picture));
  imageStore(albedo_out, p, Stored(albedo));
}
