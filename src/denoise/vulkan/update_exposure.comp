// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// Chooses the exposures and the limit of negative values (one workgroup).
#define LOCAL_SIZE_X STILLRAY_LIGHT_BINS
#define LOCAL_SIZE_Y 1
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/exposure_shared.h"
#include "denoise/vulkan/reduce.glsl"
#include "denoise/stages/limit_history_shared.h"

layout(set = 1, binding = 0, std430) readonly buffer HistorySums {
  vec4 history_sums[];  // see prepare_guides.comp
};

layout(push_constant) uniform Push {
  uint groups;          // of measure_light
  uint history_groups;  // of prepare_guides
};

shared uint bins[STILLRAY_LIGHT_BINS];
shared int limit_bin;  // brighter pixels are counted in this bin

// MeanLight of negative_limit.cpp, with an invocation for each bin. The brightest pixels, which may
// be fireflies, are counted in the bin of the next darker pixel.
float MeanLight() {
  int bin = int(gl_LocalInvocationIndex);
  uint count = bins[bin];
  // Numbers of pixels in each bin and all brighter bins.
  for (int distance = 1; distance < STILLRAY_LIGHT_BINS; distance *= 2) {
    uint brighter = bin + distance < STILLRAY_LIGHT_BINS ? bins[bin + distance] : 0u;
    barrier();
    bins[bin] += brighter;
    barrier();
  }
  uint measured = bins[0];
  uint brightest = BrightestPixels(measured);
  uint lit = bins[1];
  uint passed_before = bin + 1 < STILLRAY_LIGHT_BINS ? bins[bin + 1] : 0u;
  bool is_limit = bins[bin] > brightest && passed_before <= brightest;
  bool is_dimmest = count != 0u && bins[bin] == lit;
  if (bin > 0 && (lit > brightest ? is_limit : is_dimmest)) {
    limit_bin = bin;
  }
  barrier();
  float light = bin > 0 && count != 0u ? float(count) * LightOfBin(min(bin, limit_bin)) : 0.0f;
  float sum = SumOfGroup(vec4(light, 0.0f, 0.0f, 0.0f)).x;
  return measured > 0u ? sum / float(measured) : 0.0f;
}

// Sum of the stored luminances of the history.
vec4 SumOfHistory() {
  vec4 sum = vec4(0.0f);
  if (with_compressed != 0 && has_history != 0) {
    const uint kThreads = LOCAL_SIZE_X * LOCAL_SIZE_Y;
    const uint kLoads = 8u;  // in flight together, as in SumOfPartials
    for (uint first = gl_LocalInvocationIndex; first < history_groups; first += kLoads * kThreads) {
      vec4 loaded[kLoads];
      [[unroll]] for (uint i = 0u; i < kLoads; ++i) {
        uint group = first + i * kThreads;
        loaded[i] = group < history_groups ? history_sums[group] : vec4(0.0f);
      }
      [[unroll]] for (uint i = 0u; i < kLoads; ++i) {
        sum += loaded[i];
      }
    }
  }
  return SumOfGroup(sum);
}

// stored: mean stored luminance of signal s, i.e. times its exposure
void UpdateCompression(int s, float stored, float old_exposure) {
  old_compressed_scale[s] = compressed_scale[s];
  if (has_history == 0) {
    compressed_scale[s] = 0.0f;  // update_compression chooses it from the new samples
  } else if (with_compressed != 0) {
    compressed_scale[s] =
        CompressionScale(compressed_scale[s], max(stored / max(old_exposure, 1e-30f), 1e-20f));
  }
}

void main() {
  uint bin = gl_LocalInvocationIndex;
  bins[bin] = light_bins[bin];
  light_bins[bin] = 0u;
  barrier();
  float mean_light = MeanLight();
  vec4 light = SumOfPartials(groups, 0u);
  vec4 other = SumOfPartials(groups, 1u);
  vec4 of_history = SumOfHistory();
  if (gl_LocalInvocationIndex != 0u) {
    return;
  }
  float brightness = other.x / max(other.z, 1.0f);
  for (int s = 0; s < 4; ++s) {
    changed_blocks[s] = 0u;
    known_blocks[s] = 0u;
    float mean = light[s] / max(other.y, 1.0f);
    float old = has_history != 0 ? exposure[s] : 0.0f;
    float chosen = ChooseExposure(old, mean);
    exposure[s] = chosen;
    exposure_ratio[s] = old > 0.0f ? chosen / old : 1.0f;
    brightness += mean;
    UpdateCompression(s, of_history[s] / (float(width) * float(height)), old);
  }
  float old = has_picture != 0 ? picture_exposure : 0.0f;
  picture_exposure = ChooseExposure(old, brightness);
  picture_ratio = old > 0.0f ? picture_exposure / old : 1.0f;
  negative_limit = NegativeLimit(mean_light);
}
