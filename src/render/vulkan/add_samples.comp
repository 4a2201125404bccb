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
// With a lens the guides are those of this sample: replaces them by the mean of all up to it.
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
  guides[number] = GpuGuides(mean.normal, mean.depth, mean.albedo, mean.roughness,
                             mean.specular_albedo, mean.id, mean.emission, mean.motion_x,
                             mean.background, mean.motion_y, mean.previous_normal, 0.0f);
}

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
  if (frame.view.lens_radius > 0.0f) {
    AddGuides(number, is_first);
  }
}
#endif

void main() {
  uint number = gl_GlobalInvocationID.x;
  if (number < batch.count && IsInPicture(PixelOf(number))) {
    AddSample(number, batch.phase == kPhaseFirstSample);
  }
}
