// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Means of variances over 3x3 pixels. Each deviation is fetched once per workgroup.
const int kBlurWidth = LOCAL_SIZE_X + 2;
const int kBlurHeight = LOCAL_SIZE_Y + 2;
const int kBlurTexels = kBlurWidth * kBlurHeight;
shared float deviations[4 * kBlurTexels];  // per signal; negative: no samples, or outside

// Every invocation of the workgroup must call this before SmoothedVariance.
void LoadDeviations(texture2DArray light) {
  ivec2 first = ivec2(gl_WorkGroupID.xy) * ivec2(LOCAL_SIZE_X, LOCAL_SIZE_Y) - 1;
  for (int i = int(gl_LocalInvocationIndex); i < kBlurTexels; i += LOCAL_SIZE_X * LOCAL_SIZE_Y) {
    ivec2 q = first + ivec2(i % kBlurWidth, i / kBlurWidth);
    for (int s = 0; s < SignalCount(); ++s) {
      deviations[s * kBlurTexels + i] = Inside(q) ? texelFetch(light, ivec3(q, s), 0).w : -1.0f;
    }
  }
  barrier();
}

// The mean of the variance over those of the 3x3 pixels around the invocation's pixel that have
// samples.
float SmoothedVariance(int s) {
  ivec2 at = ivec2(gl_LocalInvocationID.xy);
  int first = s * kBlurTexels + at.y * kBlurWidth + at.x;
  float sum = 0.0f;
  float sum_weight = 0.0f;
  [[unroll]] for (int y = 0; y < 3; ++y) {
    [[unroll]] for (int x = 0; x < 3; ++x) {
      float deviation = deviations[first + y * kBlurWidth + x];
      float w = (x == 1 ? 2.0f : 1.0f) * (y == 1 ? 2.0f : 1.0f);
      w = IsValid(deviation) ? w : 0.0f;
      sum += w * VarianceOf(deviation);
      sum_weight += w;
    }
  }
  return sum / max(sum_weight, 1.0f);
}
