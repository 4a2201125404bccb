// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// tonemap: see stages/tonemap.h.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/tonemap_shared.h"

layout(set = 1, binding = 0) uniform texture2D picture;

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  vec3 c = texelFetch(picture, p, 0).xyz / picture_exposure;
  vec4 display = vec4(1.0f);
  for (int i = 0; i < 3; ++i) {
    float exposed = c[i] * tonemap.exposure_scale;
    float light = exposed > 0.0f ? min(exposed, kBrightestLight) : 0.0f;
    float noise = tonemap.dither > 0.0f
                      ? tonemap.dither * DitherNoise(uint(p.x), uint(p.y), uint(i), tonemap.frame)
                      : 0.0f;
    display[i] = floor(DisplayStep(SrgbEncode(ToneCurve(light, tonemap.tonemap)), noise)) / 255.0f;
  }
  imageStore(display_image, p, display);
}
