// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// atrous: see stages/atrous.h. All signals in one pass, which share the guides' weights.
//
// With STILLRAY_TILE a workgroup handles pixels of one residue class modulo the step. Their taps
// are neighbours in that class: the group loads its pixels and a border once into shared memory,
// and unpacks each normal once, where without every pixel fetches and unpacks all of its taps.
// Workgroups that follow each other have the residues of one region, whose cache lines they share.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/edge_stopping.glsl"
#include "denoise/vulkan/luminance_factor.glsl"

layout(constant_id = 0) const int kWeights = kAtrousSvgf;
layout(constant_id = 1) const int kRadius = 2;
layout(constant_id = 2) const int kSignals = 1;
layout(constant_id = 4) const int kCompared = 0;  // 1: a level of limit_history, on the coarse grid
layout(constant_id = 5) const int kSumsOnly = 0;  // 1: writes the sums of weights, for an output
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
    if (kSumsOnly != 0) {
      imageStore(light_out, ivec3(p, s), vec4(0.0f));
      continue;
    }
    imageStore(light_out, ivec3(p, s), texelFetch(light, ivec3(p, s), 0));
  }
}

// What a tap contributes, beside its surface.
struct Tap {
  vec4 light;
  float luminance;  // that is compared
  float factor;     // see LuminanceFactor
};

Tap FetchTap(ivec2 q, int s) {
  Tap tap;
  tap.light = texelFetch(light, ivec3(q, s), 0);
  tap.luminance = HasPilot(s) ? texelFetch(pilot, ivec3(q, s), 0).x : tap.light.x;
  tap.factor = kWeights == kAtrousSvgf
                   ? UnpackLuminanceFactor(texelFetch(factor_image, ivec3(q, s), 0).x)
                   : 0.0f;
  return tap;
}

uint FetchId(ivec2 q) {
  return UnpackDetail(texelFetch(detail_image, q, 0), 1.0f).id;
}
bool ComparesIds() {
  return kWeights != kAtrousGeometry && kWeights != kAtrousNaive && atrous.wavelet_id != 0;
}

#ifdef STILLRAY_TILE
const int kTileWidth = LOCAL_SIZE_X + 2 * kRadius;
const int kTileHeight = LOCAL_SIZE_Y + 2 * kRadius;
const int kTexels = kTileWidth * kTileHeight;
shared vec4 tile_surface[kTexels];  // normal, inverse depth; 0: no surface, or outside
shared uint tile_id[kTexels];
shared vec4 tile_light[kTexels * kSignals];
shared float tile_luminance[kTexels * kSignals];
shared float tile_factor[kTexels * kSignals];

ivec2 Residue() {
  return ivec2(gl_WorkGroupID.xy) % tap_step;
}
// The first pixel of the group, in its residue class.
ivec2 First() {
  return ivec2(gl_WorkGroupID.xy) / tap_step * ivec2(LOCAL_SIZE_X, LOCAL_SIZE_Y);
}
ivec2 Pixel() {
  return (First() + ivec2(gl_LocalInvocationID.xy)) * tap_step + Residue();
}
int TexelOf(ivec2 d) {
  ivec2 at = ivec2(gl_LocalInvocationID.xy) + kRadius + d;
  return at.y * kTileWidth + at.x;
}

void LoadTexel(int texel) {
  ivec2 at = ivec2(texel % kTileWidth, texel / kTileWidth);
  ivec2 q = (First() + at - kRadius) * tap_step + Residue();
  bool inside = InLevel(q);
  Surface surface = Surface(0.0f, vec3(0.0f));
  if (inside) {
    surface = UnpackSurface(texelFetch(surface_image, q, 0));
    tile_id[texel] = ComparesIds() ? FetchId(q) : 0u;
  }
  tile_surface[texel] = vec4(surface.normal, surface.inverse_depth);
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    if (inside) {
      Tap tap = FetchTap(q, s);
      tile_light[texel * kSignals + s] = tap.light;
      tile_luminance[texel * kSignals + s] = tap.luminance;
      tile_factor[texel * kSignals + s] = tap.factor;
    }
  }
}
void LoadTile() {
  for (int texel = int(gl_LocalInvocationIndex); texel < kTexels;
       texel += LOCAL_SIZE_X * LOCAL_SIZE_Y) {
    LoadTexel(texel);
  }
  barrier();
}

Surface SurfaceAt(ivec2 p, ivec2 d) {
  vec4 texel = tile_surface[TexelOf(d)];
  return Surface(texel.w, texel.xyz);
}
uint IdAt(ivec2 p, ivec2 d) {
  return tile_id[TexelOf(d)];
}
Tap TapAt(ivec2 p, ivec2 d, int s) {
  int texel = TexelOf(d) * kSignals + s;
  return Tap(tile_light[texel], tile_luminance[texel], tile_factor[texel]);
}
#else
ivec2 Pixel() {
  return ivec2(gl_GlobalInvocationID.xy);
}
void LoadTile() {}
Surface SurfaceAt(ivec2 p, ivec2 d) {
  return UnpackSurface(texelFetch(surface_image, p + d * tap_step, 0));
}
uint IdAt(ivec2 p, ivec2 d) {
  return FetchId(p + d * tap_step);
}
Tap TapAt(ivec2 p, ivec2 d, int s) {
  return FetchTap(p + d * tap_step, s);
}
#endif

// The exponent of 2 of the luminance weight of q for signal s.
float LuminanceExponent2(Tap own, Tap q, int s) {
  if (kWeights == kAtrousSvgf) {
    float dl = IsValid(own.light.w) || !HasPilot(s) ? abs(own.luminance - q.luminance) : 0.0f;
    return -dl * SharedLuminanceFactor(own.factor, q.factor, atrous.noise_ratio);
  }
  if (kWeights == kAtrousEaw) {
    float dl = IsValid(own.light.w) ? abs(own.light.x - q.light.x) : 0.0f;
    return -kExponentsOfE * EawExponent(dl * dl, 0.0f, 0.0f, EawSigma(s), 1.0f, 1.0f);
  }
  return 0.0f;
}

void main() {
  LoadTile();
  ivec2 p = Pixel();
  if (!InLevel(p)) {
    return;
  }
  Surface surface = SurfaceAt(p, ivec2(0));
  if (!(surface.inverse_depth > 0.0f)) {
    PassThrough(p);
    return;
  }
  Detail detail = UnpackDetail(texelFetch(detail_image, p, 0), surface.inverse_depth);
  EdgeStopping edges = LevelEdges();
  float sigma_n = edges.sigma_n;
  if (edges.curvature > 0.0f && (kWeights == kAtrousGeometry || kWeights == kAtrousSvgf)) {
    float turn2 = Turn2At(edges, surface_image, surface.normal, p);
    sigma_n = CurvedSigmaN(edges.sigma_n, turn2, edges.curvature);
  }
  Tap own[kSignals];
  vec4 sum[kSignals];  // light, variance
  float sum_weight[kSignals];
  bool any = kWeights != kAtrousGeometry;
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    own[s] = TapAt(p, ivec2(0), s);
    any = any || IsValid(own[s].light.w);
    sum[s] = vec4(0.0f);
    sum_weight[s] = 0.0f;
  }
  if (!any) {
    PassThrough(p);  // the value is not used
    return;
  }
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      ivec2 d = ivec2(dx, dy);
      if (!InLevel(p + d * tap_step)) {
        continue;
      }
      bool centre = dx == 0 && dy == 0;
      float h = KernelWeight(dx) * KernelWeight(dy);
      float exponent2 = 0.0f;  // of the weights that all signals share
      if (kWeights != kAtrousNaive && !centre) {
        Surface other = SurfaceAt(p, d);
        if (!(other.inverse_depth > 0.0f)) {
          continue;
        }
        if (ComparesIds() && IdAt(p, d) != detail.id) {
          continue;
        }
        vec2 offset = vec2(d * tap_step);
        if (kWeights == kAtrousEaw) {
          float distance = PlaneDepthExponent(surface.inverse_depth, other.inverse_depth,
                                              detail.gradient, offset, 1.0f);
          vec3 dn = surface.normal - other.normal;
          exponent2 = -kExponentsOfE * EawExponent(0.0f, dot(dn, dn), distance * distance, 1.0f,
                                                   atrous.eaw_sigma_n, atrous.eaw_sigma_z);
        } else {
          exponent2 = GeometryExponent2(edges, surface, detail, sigma_n, other, offset);
        }
      }
      [[unroll]] for (int s = 0; s < kSignals; ++s) {
        Tap q = TapAt(p, d, s);
        if (!IsValid(q.light.w)) {
          continue;
        }
        // One exponential for all weights of a tap.
        float w = centre ? h : h * exp2(exponent2 + LuminanceExponent2(own[s], q, s));
        sum[s] += vec4(w * q.light.xyz, w * w * VarianceOf(q.light.w));
        sum_weight[s] += w;
      }
    }
  }
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    if (kSumsOnly != 0) {
      imageStore(light_out, ivec3(p, s), vec4(sum_weight[s]));
      continue;
    }
    // Smaller sums have lost their precision: no neighbour is similar to this pixel.
    bool filled = sum_weight[s] > kMinAtrousWeight;
    float inverse = filled ? 1.0f / sum_weight[s] : 0.0f;
    vec3 c = filled ? sum[s].xyz * inverse : own[s].light.xyz;
    float variance = filled ? sum[s].w * inverse * inverse : VarianceOf(own[s].light.w);
    bool valid =
        IsValid(own[s].light.w) || (atrous.grows != 0 && kWeights != kAtrousGeometry && filled);
    imageStore(light_out, ivec3(p, s), Stored(vec4(c, PackDeviation(variance, valid))));
  }
}
