// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// reproject: see stages/reproject.h. Finds each pixel's taps once and fetches the history of all
// signals along them.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/fetch_history.glsl"

layout(set = 1, binding = 8, LIGHT_FORMAT) writeonly uniform image2DArray colour_out;
layout(set = 1, binding = 9, LIGHT_FORMAT) writeonly uniform image2DArray behind_out;
layout(set = 1, binding = 10, LIGHT_FORMAT) writeonly uniform image2DArray moments_out;
layout(set = 1, binding = 11, FRACTION_FORMAT) writeonly uniform image2DArray compressed_out;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  Taps taps = FindTaps(p);
  float confidence = Confidence(p);
  for (int s = 0; s < SignalCount(); ++s) {
    ivec3 at = ivec3(p, s);
    Fetched fetched = Fetch(taps, confidence, s);
    imageStore(colour_out, at, vec4(fetched.colour, 0.0f));
    imageStore(moments_out, at, fetched.moments);
    if (with_behind != 0) {
      imageStore(behind_out, at, vec4(fetched.behind, 0.0f));
    }
    if (with_compressed != 0) {
      imageStore(compressed_out, at, vec4(fetched.compressed));
    }
  }
}
