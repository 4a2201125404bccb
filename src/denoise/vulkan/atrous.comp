// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// atrous: see stages/atrous.h. All signals in one pass, which share the guides' weights.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/edge_stopping.glsl"
#include "denoise/vulkan/luminance_factor.glsl"

layout(constant_id = 0) const int kWeights = kAtrousSvgf;
layout(constant_id = 1) const int kRadius = 2;
layout(constant_id = 2) const int kSignals = 1;
layout(constant_id = 4) const int kCompared = 0;  // 1: a level of limit_history, on the coarse grid
layout(constant_id = 3) const int kPilot = 0;     // bit s: weights of signal s compare the pilot

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2DArray light;
layout(set = 1, binding = 3) uniform texture2DArray factor_image;
layout(set = 1, binding = 4) uniform texture2DArray pilot;  // read with kPilot only
layout(set = 1, binding = 5, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

layout(push_constant) uniform Push {
  int tap_step;
  int level;
  int box;  // 1: all taps have the same weight before the edge-stopping functions
};

bool HasPilot(int s) {
  return (kPilot >> s & 1) != 0;
}

EdgeStopping LevelEdges() {
  if (kCompared != 0) {
    return compared.edges;
  }
  return atrous.edges;
}

bool InLevel(ivec2 p) {
  ivec2 size = kCompared != 0 ? (Size() + 1) / 2 : Size();
  return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size));
}

float KernelWeight(int d) {
  if (box != 0) {
    return 1.0f;
  }
  int i = abs(d);
  return kRadius == 1 ? (i == 0 ? 0.5f : 0.25f) : (i == 0 ? 0.375f : (i == 1 ? 0.25f : 0.0625f));
}

float EawSigma(int s) {
  return atrous.eaw_sigma_l * mean_luminance[s] * exposure[s] * exp2(-float(level));
}

void PassThrough(ivec2 p) {
  for (int s = 0; s < kSignals; ++s) {
    imageStore(light_out, ivec3(p, s), texelFetch(light, ivec3(p, s), 0));
  }
}

// The luminance weight of q for signal s; q_light, q_factor: its light and reciprocal denominator.
// luminance: what p is compared by.
float LuminanceWeight(vec4 own, float luminance, float own_factor, vec4 q_light, ivec3 q,
                      float exponent, int s) {
  if (kWeights == kAtrousSvgf) {
    float q_luminance = HasPilot(s) ? texelFetch(pilot, q, 0).x : q_light.x;
    float dl = IsValid(own.w) || !HasPilot(s) ? abs(luminance - q_luminance) : 0.0f;
    float q_factor = UnpackLuminanceFactor(texelFetch(factor_image, q, 0).x);
    return exp2(-dl * SharedLuminanceFactor(own_factor, q_factor, atrous.noise_ratio));
  }
  if (kWeights == kAtrousEaw) {
    float dl = IsValid(own.w) ? abs(own.x - q_light.x) : 0.0f;
    return exp(-(exponent + EawExponent(dl * dl, 0.0f, 0.0f, EawSigma(s), 1.0f, 1.0f)));
  }
  return 1.0f;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!InLevel(p)) {
    return;
  }
  Surface surface = UnpackSurface(texelFetch(surface_image, p, 0));
  if (!(surface.inverse_depth > 0.0f)) {
    PassThrough(p);
    return;
  }
  Detail detail = UnpackDetail(texelFetch(detail_image, p, 0), surface.inverse_depth);
  float turn2 = Turn2At(LevelEdges(), surface_image, surface.normal, p);
  vec4 own[kSignals];
  float own_factor[kSignals];
  float own_luminance[kSignals];
  vec4 sum[kSignals];  // light, variance
  float sum_weight[kSignals];
  bool any = kWeights != kAtrousGeometry;
  for (int s = 0; s < kSignals; ++s) {
    own[s] = texelFetch(light, ivec3(p, s), 0);
    any = any || IsValid(own[s].w);
    own_luminance[s] = HasPilot(s) ? texelFetch(pilot, ivec3(p, s), 0).x : own[s].x;
    own_factor[s] = kWeights == kAtrousSvgf
                        ? UnpackLuminanceFactor(texelFetch(factor_image, ivec3(p, s), 0).x)
                        : 0.0f;
    sum[s] = vec4(0.0f);
    sum_weight[s] = 0.0f;
  }
  if (!any) {
    PassThrough(p);  // the value is not used
    return;
  }
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      ivec2 q = p + ivec2(dx, dy) * tap_step;
      if (!InLevel(q)) {
        continue;
      }
      bool centre = dx == 0 && dy == 0;
      float h = KernelWeight(dx) * KernelWeight(dy);
      float exponent = 0.0f;
      if (kWeights != kAtrousNaive && !centre) {
        Surface other = UnpackSurface(texelFetch(surface_image, q, 0));
        if (!(other.inverse_depth > 0.0f)) {
          continue;
        }
        if (kWeights != kAtrousGeometry && atrous.wavelet_id != 0 &&
            UnpackDetail(texelFetch(detail_image, q, 0), 1.0f).id != detail.id) {
          continue;
        }
        vec2 offset = vec2(q - p);
        if (kWeights == kAtrousEaw) {
          float distance = PlaneDepthExponent(surface.inverse_depth, other.inverse_depth,
                                              detail.gradient, offset, 1.0f);
          vec3 dn = surface.normal - other.normal;
          exponent = EawExponent(0.0f, dot(dn, dn), distance * distance, 1.0f, atrous.eaw_sigma_n,
                                 atrous.eaw_sigma_z);
        } else {
          h *= GeometryWeight(LevelEdges(), surface, detail, turn2, other, offset);
        }
      }
      for (int s = 0; s < kSignals; ++s) {
        vec4 q_light = centre ? own[s] : texelFetch(light, ivec3(q, s), 0);
        if (!IsValid(q_light.w)) {
          continue;
        }
        float w = centre ? h
                         : h * LuminanceWeight(own[s], own_luminance[s], own_factor[s], q_light,
                                               ivec3(q, s), exponent, s);
        sum[s] += vec4(w * q_light.xyz, w * w * VarianceOf(q_light.w));
        sum_weight[s] += w;
      }
    }
  }
  for (int s = 0; s < kSignals; ++s) {
    // Smaller sums have lost their precision: no neighbour is similar to this pixel.
    bool filled = sum_weight[s] > kMinAtrousWeight;
    float inverse = filled ? 1.0f / sum_weight[s] : 0.0f;
    vec3 c = filled ? sum[s].xyz * inverse : own[s].xyz;
    float variance = filled ? sum[s].w * inverse * inverse : VarianceOf(own[s].w);
    bool valid = IsValid(own[s].w) || (atrous.grows != 0 && kWeights != kAtrousGeometry && filled);
    imageStore(light_out, ivec3(p, s), Stored(vec4(c, PackDeviation(variance, valid))));
  }
}
