// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Adds a sample to the sums of its pixels. With STILLRAY_REFERENCE the radiance of all signals is
// added to the first signal, and the second holds the rounding error (compensated summation, Kahan
// 1965, "Further remarks on reducing truncation errors"), since sums of many samples would lose
// small contributions.
#include "render/vulkan/tracer.glsl"

layout(local_size_x = 64) in;

#ifdef STILLRAY_REFERENCE
void AddSample(uint number, bool is_first) {
  vec3 light = guides[number].emission + guides[number].background;
  uint signals = FirstSignal(number);
  for (uint k = 0u; k < frame.signal_count; ++k) {
    light += sample_lights[signals + k].light;
  }
  vec3 sum = is_first ? vec3(0.0f) : sums[signals].light;
  vec3 lost = is_first ? vec3(0.0f) : sums[signals + 1u].light;
  precise vec3 added = light - lost;
  precise vec3 larger = sum + added;
  precise vec3 kept = larger - sum;
  precise vec3 now_lost = kept - added;
  sums[signals].light = larger;
  sums[signals + 1u].light = now_lost;
}
#else
// With a lens: replaces the guides of this sample by the mean of all samples so far.
void AddGuides(uint number, bool is_first) {
  GpuGuides g = guides[number];
  LensGuides one =
      LensGuides(g.albedo, g.depth, g.specular_albedo, g.roughness, g.emission, g.motion_x,
                 g.background, g.motion_y, g.normal, g.id, 1, 1, 1, 0, g.previous_normal, 0.0f);
  LensGuides sum = one;
  if (!is_first) {
    sum = lens_sums[number];
    AddLensSample(sum, one);
  }
  lens_sums[number] = sum;
  LensGuides mean = MeanOfLensSamples(sum);
  guides[number] =
      GpuGuides(mean.normal, mean.depth, mean.albedo, mean.roughness, mean.specular_albedo, mean.id,
                mean.emission, mean.motion_x, mean.background, mean.motion_y, mean.previous_normal,
                0u, vec3(0.0f), 0u);
}

// The albedo by which a SignalKind is demodulated.
vec3 AlbedoOf(uint number, uint kind) {
  if (kind >= uint(kDirectTransmission)) {
    return guides[number].transmission_albedo;
  }
  return kind >= uint(kDirectSpecular) ? guides[number].specular_albedo : guides[number].albedo;
}

void AddSample(uint number, bool is_first) {
  for (uint k = 0u; k < frame.signal_count; ++k) {
    uint signal = FirstSignal(number) + k;
    vec3 light = sample_lights[signal].light;
    GpuSignal sum = GpuSignal(vec3(0.0f), 0.0f);
    if (!is_first) {
      sum = sums[signal];
    }
    sum.light += light;
    if (frame.with_squares != 0) {
      vec3 albedo = AlbedoOf(number, k);
      float l = Luminance709(Demodulate(light.x, albedo.x), Demodulate(light.y, albedo.y),
                             Demodulate(light.z, albedo.z));
      sum.square += l * l;
    }
    sums[signal] = sum;
  }
  if (frame.view.lens_radius > 0.0f) {
    AddGuides(number, is_first);
  }
}
#endif

void main() {
  uint number = gl_GlobalInvocationID.x;
  if (number < batch.count && !IsStopped() && IsInPicture(PixelOf(number))) {
    AddSample(number, batch.phase == kPhaseFirstSample);
  }
}
