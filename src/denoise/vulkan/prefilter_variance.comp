// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// prefilter_variance: see stages/prefilter_variance.h. Stores the denominator of the luminance
// weight, the inverse of LuminanceFactor; kNoLuminanceWeight where the weight is 1.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/luminance_factor.glsl"
#include "denoise/vulkan/smoothed_variance.glsl"

layout(set = 1, binding = 0) uniform texture2DArray light;
layout(set = 1, binding = 1) uniform texture2DArray moments;
layout(set = 1, binding = 2, SCALAR_FORMAT) writeonly uniform image2DArray factor_out;

void main() {
  LoadDeviations(light);
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  bool widens = prefilter_variance.volume_widening > 1.0f && has_confidence != 0;
  for (int s = 0; s < SignalCount(); ++s) {
    vec4 own = texelFetch(light, ivec3(p, s), 0);
    bool bounded = IsValid(own.w);
    if (prefilter_variance.short_history_blur > 0.0f) {
      float history_length = max(texelFetch(moments, ivec3(p, s), 0).z, 0.0f);
      bounded = bounded && history_length >= prefilter_variance.short_history_blur;
    }
    float own_variance = IsValid(own.w) ? VarianceOf(own.w) : 0.0f;
    float smoothed =
        prefilter_variance.prefilter_variance != 0
            ? LimitedVariance(SmoothedVariance(s), own_variance, prefilter_variance.prefilter_limit)
            : own_variance;
    // The exposure is removed, since PSVGF's use of the variance depends on it.
    float spread =
        prefilter_variance.luminance_scale_deviation != 0 ? sqrt(smoothed) : smoothed / exposure[s];
    float sigma_l = prefilter_variance.sigma_l;
    if (widens && (prefilter_variance.volume_signals >> s & 1) != 0) {
      sigma_l *= VolumeWidening(Confidence(p), prefilter_variance.volume_widening);
    }
    float factor =
        bounded ? LuminanceFactor(own.x, spread, sigma_l, prefilter_variance.luminance_epsilon,
                                  prefilter_variance.luminance_floor * exposure[s])
                : 0.0f;
    imageStore(factor_out, ivec3(p, s), vec4(PackLuminanceFactor(factor)));
  }
}
