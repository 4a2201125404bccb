// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The new samples of one signal at a pixel, from the caller's images: see stages/demodulate.h.
// Loops over kinds are unrolled, since each kind is a separate image.
#include "denoise/stages/suppress_fireflies_shared.h"

vec3 LoadLight(int kind, ivec2 p) {
  switch (kind) {
    case 0:
      return texelFetch(light_0, p, 0).xyz;
    case 1:
      return texelFetch(light_1, p, 0).xyz;
    case 2:
      return texelFetch(light_2, p, 0).xyz;
    case 3:
      return texelFetch(light_3, p, 0).xyz;
    case 4:
      return texelFetch(light_4, p, 0).xyz;
    default:
      return texelFetch(light_5, p, 0).xyz;
  }
}

float LoadSecondMoment(int kind, ivec2 p) {
  switch (kind) {
    case 0:
      return texelFetch(second_moment_0, p, 0).x;
    case 1:
      return texelFetch(second_moment_1, p, 0).x;
    case 2:
      return texelFetch(second_moment_2, p, 0).x;
    case 3:
      return texelFetch(second_moment_3, p, 0).x;
    case 4:
      return texelFetch(second_moment_4, p, 0).x;
    default:
      return texelFetch(second_moment_5, p, 0).x;
  }
}

// which: 0 albedo, 1 specular, 2 transmission
vec3 LoadAlbedo(int which, ivec2 p) {
  return which == 0   ? texelFetch(albedo_image, p, 0).xyz
         : which == 1 ? texelFetch(specular_albedo_image, p, 0).xyz
                      : texelFetch(transmission_albedo_image, p, 0).xyz;
}

int LightsOf(int signal) {
  return lights & (signal == 0   ? lights_of_0
                   : signal == 1 ? lights_of_1
                   : signal == 2 ? lights_of_2
                                 : lights_of_3);
}

int AlbedosOf(int signal) {
  return albedos & (signal == 0   ? albedos_of_0
                    : signal == 1 ? albedos_of_1
                    : signal == 2 ? albedos_of_2
                                  : albedos_of_3);
}

vec3 AlbedoSum(int signal, ivec2 p) {
  vec3 sum = vec3(0.0f);
  [[unroll]] for (int i = 0; i < 3; ++i) {
    if ((AlbedosOf(signal) >> i & 1) != 0) {
      sum += LoadAlbedo(i, p);
    }
  }
  return sum;
}

vec3 Demodulate(vec3 radiance, vec3 albedo) {
  return vec3(Demodulate(radiance.x, albedo.x), Demodulate(radiance.y, albedo.y),
              Demodulate(radiance.z, albedo.z));
}

float Luminance(vec3 c) {
  return demodulate.luminance_rec601 != 0 ? Luminance601(c.x, c.y, c.z)
                                          : Luminance709(c.x, c.y, c.z);
}

// The channel of the radiance that the signal contains; -1: all.
int ChannelOf(int signal) {
  return by_channel != 0 ? signal : -1;
}

struct NewLight {
  vec3 colour;  // luminance, red, blue (LumaImage3 on the CPU); zero if the sample is missing
  float samples;
  bool non_finite;
  bool negative;
};

// limit: values in (-limit, 0) become zero.
NewLight LoadNewLight(int signal, ivec2 p, float limit) {
  int kinds = LightsOf(signal);
  vec3 sum = vec3(0.0f);
  bool finite = true;
  bool negative = false;
  [[unroll]] for (int k = 0; k < 6; ++k) {
    if ((kinds >> k & 1) != 0) {
      vec3 light = LoadLight(k, p);
      finite = finite && IsFinite(light);
      negative = negative || min(light.x, min(light.y, light.z)) < -limit;
      sum += max(light, vec3(0.0f));
    }
  }
  vec3 albedo = AlbedosOf(signal) != 0 ? AlbedoSum(signal, p) : vec3(1.0f);
  vec3 colour = AlbedosOf(signal) != 0 ? Demodulate(sum, albedo) : sum;
  finite = finite && IsFinite(colour) && IsFinite(albedo);
  float given = GivenSamples(p);
  bool usable = finite && !negative && given > 0.0f && IsFinite(given);
  float l = Luminance(colour);
  if (by_channel != 0) {
    l = colour[ChannelOf(signal)];
    colour = vec3(l);
  }
  NewLight result;
  float scale = demodulate.firefly == 2 ? CompressScale(l) : 1.0f;
  result.colour = usable ? scale * vec3(l, colour.x, colour.z) : vec3(0.0f);
  result.samples = usable ? given : 0.0f;
  bool is_first = ChannelOf(signal) <= 0;  // the other channels have the same invalid pixels
  result.non_finite = is_first && given > 0.0f && !finite;
  result.negative = is_first && given > 0.0f && finite && negative;
  return result;
}

// Variance of single samples within the pixel, which must have valid samples.
float WithinVariance(int signal, ivec2 p) {
  int kinds = LightsOf(signal) & second_moments;
  vec3 albedo = AlbedosOf(signal) != 0 ? AlbedoSum(signal, p) : vec3(1.0f);
  float sum = 0.0f;
  [[unroll]] for (int k = 0; k < 6; ++k) {
    if ((kinds >> k & 1) == 0) {
      continue;
    }
    int which = k < 2 ? 0 : (k < 4 ? 1 : 2);
    vec3 own = (own_albedos >> which & 1) != 0 ? LoadAlbedo(which, p) : vec3(1.0f);
    vec3 mean_colour = Demodulate(LoadLight(k, p), own);
    float mean = Luminance709(mean_colour.x, mean_colour.y, mean_colour.z);
    float ratio = max(Luminance709(own.x, own.y, own.z), kAlbedoFloor) /
                  max(Luminance709(albedo.x, albedo.y, albedo.z), kAlbedoFloor);
    if (by_channel != 0) {
      int c = ChannelOf(signal);
      ratio = ChannelDeviation(mean_colour[c], mean, own[c], albedo[c]);
    }
    sum += max(LoadSecondMoment(k, p) - mean * mean, 0.0f) * ratio * ratio;
  }
  return IsFinite(sum) ? sum : 0.0f;
}
