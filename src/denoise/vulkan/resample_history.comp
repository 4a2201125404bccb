// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Resamples the history of the last frame to the size of this frame: bilinear, over the pixels that
// show the surface of the nearest pixel, whose guides resample_guides uses.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/resample.glsl"

layout(set = 1, binding = 0) uniform utexture2D surface_before;
layout(set = 1, binding = 1) uniform texture2DArray colour;
layout(set = 1, binding = 2) uniform texture2DArray behind;
layout(set = 1, binding = 3) uniform texture2DArray moments;
layout(set = 1, binding = 4) uniform texture2DArray compressed;
layout(set = 1, binding = 5, LIGHT_FORMAT) writeonly uniform image2DArray colour_out;
layout(set = 1, binding = 6, LIGHT_FORMAT) writeonly uniform image2DArray behind_out;
layout(set = 1, binding = 7, LIGHT_FORMAT) writeonly uniform image2DArray moments_out;
layout(set = 1, binding = 8, FRACTION_FORMAT) writeonly uniform image2DArray compressed_out;

const float kLeastCosine = 0.9f;
const float kMostDepthRatio = 1.1f;

bool SameSurface(Surface a, Surface b) {
  bool none = a.inverse_depth <= 0.0f && b.inverse_depth <= 0.0f;
  bool near = max(a.inverse_depth, b.inverse_depth) <=
              kMostDepthRatio * min(a.inverse_depth, b.inverse_depth);
  return none || (near && dot(a.normal, b.normal) >= kLeastCosine);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  Surface nearest = UnpackSurface(texelFetch(surface_before, NearestBefore(p), 0));
  PixelsBefore pixels = AroundBefore(p);
  for (int i = 0; i < 4; ++i) {
    Surface other = UnpackSurface(texelFetch(surface_before, pixels.at[i], 0));
    pixels.weight[i] = SameSurface(nearest, other) ? pixels.weight[i] : 0.0f;
  }
  for (int s = 0; s < SignalCount(); ++s) {
    vec4 c = vec4(0.0f);
    vec4 b = vec4(0.0f);
    vec4 m = vec4(0.0f);
    float k = 0.0f;
    float all = 0.0f;
    float lit = 0.0f;  // as in reproject: pixels of length 0 have no radiance
    float history_length = 0.0f;
    for (int i = 0; i < 4; ++i) {
      ivec3 at = ivec3(pixels.at[i], s);
      float w = pixels.weight[i];
      vec4 of_tap = texelFetch(moments, at, 0);
      all += w;
      history_length += w * max(of_tap.z, 0.0f);
      w = of_tap.z > 0.0f ? w : 0.0f;
      lit += w;
      c += w * texelFetch(colour, at, 0);
      b += with_behind != 0 ? w * texelFetch(behind, at, 0) : vec4(0.0f);
      m += w * vec4(of_tap.x, VarianceOf(of_tap.y), 0.0f, of_tap.w);
      k += with_compressed != 0 ? w * texelFetch(compressed, at, 0).x : 0.0f;
    }
    float scale = lit > 0.0f ? 1.0f / lit : 0.0f;
    m *= scale;
    m.y = PackDeviation(m.y, true);
    m.z = all > 0.0f ? history_length / all : -1.0f;
    ivec3 at = ivec3(p, s);
    imageStore(colour_out, at, Stored(c * scale));
    imageStore(moments_out, at, Stored(m));
    if (with_behind != 0) {
      imageStore(behind_out, at, Stored(b * scale));
    }
    if (with_compressed != 0) {
      imageStore(compressed_out, at, vec4(k * scale));
    }
  }
}
