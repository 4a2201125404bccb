// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The mean of the variance over the (2 radius + 1)^2 pixels around one, of those that have light.
float SmoothedVariance(texture2DArray light, int radius, ivec3 at) {
  float sum = 0.0f;
  float sum_weight = 0.0f;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      ivec2 q = at.xy + ivec2(dx, dy);
      float deviation = Inside(q) ? texelFetch(light, ivec3(q, at.z), 0).w : -1.0f;
      float w = (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f);
      w = IsValid(deviation) ? w : 0.0f;
      sum += w * VarianceOf(deviation);
      sum_weight += w;
    }
  }
  return sum / max(sum_weight, 1.0f);
}
