// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Adds a sample to the sums of its pixels. With STILLRAY_REFERENCE all light of the sample is added
// to the first of the signals, with the rounding error in the second: sums of many samples would
// lose small ones (Kahan 1965, "Further remarks on reducing truncation errors").
#include "render/vulkan/tracer.glsl"

layout(local_size_x = 64) in;

#ifdef STILLRAY_REFERENCE
void AddSample(uint number, bool is_first) {
  vec3 light = guides[number].emission + guides[number].background;
  for (int k = 0; k < 4; ++k) {
    light += sample_lights[number].signals[k].light;
  }
  vec3 sum = is_first ? vec3(0.0f) : sums[number].signals[0].light;
  vec3 lost = is_first ? vec3(0.0f) : sums[number].signals[1].light;
  precise vec3 added = light - lost;
  precise vec3 larger = sum + added;
  precise vec3 kept = larger - sum;
  precise vec3 now_lost = kept - added;
  sums[number].signals[0].light = larger;
  sums[number].signals[1].light = now_lost;
}
#else
void AddSample(uint number, bool is_first) {
  for (int k = 0; k < 4; ++k) {
    vec3 light = sample_lights[number].signals[k].light;
    GpuSignal sum = GpuSignal(vec3(0.0f), 0.0f);
    if (!is_first) {
      sum = sums[number].signals[k];
    }
    sum.light += light;
    if (frame.with_squares != 0) {
      vec3 albedo = k < 2 ? guides[number].albedo : guides[number].specular_albedo;
      float l = Luminance709(Demodulate(light.x, albedo.x), Demodulate(light.y, albedo.y),
                             Demodulate(light.z, albedo.z));
      sum.square += l * l;
    }
    sums[number].signals[k] = sum;
  }
}
#endif

void main() {
  uint number = gl_GlobalInvocationID.x;
  if (number < batch.count && IsInPicture(PixelOf(number))) {
    AddSample(number, batch.phase == kPhaseFirstSample);
  }
}
