// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The new history of a pixel: see stages/accumulate.h. Include after common.glsl; requires
//   vec4 LoadNoisy(ivec3 at), float LoadWithin(ivec3 at)
#include "denoise/stages/accumulate_shared.h"

// Colour, moments with a deviation, colour before feedback, and compressed luminance.
struct NewHistory {
  vec4 colour;
  vec4 moments;
  vec4 behind;
  float compressed;
};

// m: moments with a variance; at: pixel and signal; least: LeastWeights; history_length, ratio:
// from limit_history.
NewHistory Accumulate(ivec3 at, vec3 colour, vec4 m, vec3 behind, float compressed,
                      float history_length, float ratio, vec2 least) {
  vec4 light = LoadNoisy(at);
  float n = light.w;
  if (accumulate.max_history > 0) {
    history_length = min(history_length, max(float(accumulate.max_history) - n, 0.0f));
  }
  float alpha = NewFrameWeight(history_length, n, least.x, accumulate.history_weight_constant != 0);
  float alpha_of_moments =
      NewFrameWeight(history_length, n, least.y, accumulate.history_weight_constant != 0);
  float d = light.x - m.x;
  float within = second_moments != 0 ? VarianceOf(LoadWithin(at)) : 0.0f;
  float variance = MixedVariance(m.y, d, within, alpha_of_moments);
  NewHistory history;
  history.colour = Stored(vec4(colour + alpha * (light.xyz - colour), 0.0f));
  history.moments = Stored(vec4(m.x + alpha_of_moments * d, PackDeviation(variance, true),
                                min(n > 0.0f ? history_length + n : m.z, kMostLength),
                                MixedWeights2(m.w, n, alpha)));
  history.behind = Stored(vec4(behind + alpha * (light.xyz - behind), 0.0f));
  float now = CompressLuminance(light.x, compressed_scale[at.z] * exposure[at.z]);
  float old = ratio != 1.0f ? ScaledCompressed(compressed, ratio) : compressed;
  history.compressed = old + alpha * (now - old);
  return history;
}

// The least weights of a new frame in the colour and in the moments.
vec2 LeastWeights(float confidence) {
  return vec2(ConfidentAlpha(accumulate.alpha_min, confidence),
              ConfidentAlpha(accumulate.alpha_moments, confidence));
}
