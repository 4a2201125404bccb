// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// atrous: see stages/atrous.h. All signals in one pass, which share the guides' weights.
//
// With STILLRAY_TILE a workgroup handles pixels of some residue classes modulo the step. Their taps
// are neighbours in their class: the group loads its pixels and a border once into shared memory,
// and unpacks each normal once, where without every pixel fetches and unpacks all of its taps.
// The classes lie side by side, so that their texels share cache lines.
#include "denoise/vulkan/common.glsl"
#include "denoise/vulkan/edge_stopping.glsl"
#include "denoise/vulkan/luminance_factor.glsl"
#include "denoise/stages/estimate_variance_shared.h"

layout(constant_id = 2) const int kWeights = kAtrousSvgf;  // kAtrousNaive ...: see atrous_shared.h
layout(constant_id = 3) const int kRadius = 2;             // of the kernel: 1, 2
layout(constant_id = 4) const int kPilot = 0;     // bit s: weights of signal s compare the pilot
layout(constant_id = 5) const int kCompared = 0;  // 1: a level of limit_history, on the coarse grid
layout(constant_id = 6) const int kOutput = kAtrousLight;  // or kAtrousSums, kAtrousPilot
layout(constant_id = 7) const int kEdgeKinds = 0;          // STILLRAY_ATROUS_...: kinds of weights
#ifdef STILLRAY_TILE
layout(constant_id = 8) const int kStep = 1;  // tap_step
#endif

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2DArray light;
layout(set = 1, binding = 3) uniform texture2DArray factor_image;
layout(set = 1, binding = 4) uniform texture2DArray pilot;        // with kAtrousPilot: moments
layout(set = 1, binding = 5) uniform texture2DArray turn2_image;  // read on curved surfaces only
layout(set = 1, binding = 6, LIGHT_FORMAT) writeonly uniform image2DArray light_out;

layout(push_constant) uniform Push {
  int tap_step;  // pixels between taps
  int level;
  int box;            // 1: all taps have the same weight before the edge-stopping functions
  int pilot_signals;  // with kAtrousPilot: those that get one; others keep their light
};

const int kSignals = kKnownSignals;

const bool kCurved = (kEdgeKinds & STILLRAY_ATROUS_CURVED) != 0;
const bool kPlanes = (kEdgeKinds & STILLRAY_ATROUS_PLANES) != 0;
const bool kPositions = (kEdgeKinds & STILLRAY_ATROUS_POSITIONS) != 0;
const bool kComparesIds = (kEdgeKinds & STILLRAY_ATROUS_IDS) != 0 && kWeights != kAtrousGeometry &&
                          kWeights != kAtrousNaive;

bool HasPilot(int s) {
  return (kPilot >> s & 1) != 0;
}

EdgeStopping LevelEdges() {
  if (kCompared != 0) {
    return compared.edges;
  }
  return atrous.edges;
}

ivec2 LevelSize() {
  return kCompared != 0 ? (Size() + 1) / 2 : Size();
}
bool InLevel(ivec2 p) {
  return all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, LevelSize()));
}
ivec2 ClampToLevel(ivec2 p) {
  return clamp(p, ivec2(0), LevelSize() - 1);
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

// The pilot estimate: the mean of a pixel's neighbourhood, mixed with its own light for longer
// histories (stages/mix_pilot.h).
vec4 MixPilot(ivec2 p, int s, vec4 own, vec3 mean, float variance) {
  float share = (pilot_signals >> s & 1) != 0 ? PilotShare(texelFetch(pilot, ivec3(p, s), 0).z,
                                                           estimate_variance.short_history_length)
                                              : 0.0f;
  float mixed = PilotVariance(VarianceOf(own.w), variance, share);
  return vec4(own.xyz + share * (mean - own.xyz), PackDeviation(mixed, IsValid(own.w)));
}

void PassThrough(ivec2 p) {
  for (int s = 0; s < kSignals; ++s) {
    vec4 own = texelFetch(light, ivec3(p, s), 0);
    vec4 result = own;
    if (kOutput == kAtrousSums) {
      result = vec4(0.0f);
    } else if (kOutput == kAtrousPilot) {
      result = MixPilot(p, s, own, own.xyz, VarianceOf(own.w));
    }
    imageStore(light_out, ivec3(p, s), Stored(result));
  }
}

// The light of a tap.
struct Tap {
  vec4 light;       // negative deviation: none, or no surface
  float luminance;  // that is compared
  float factor;     // see LuminanceFactor
};
// Outside the picture, or where there is no surface: no light.
const Tap kNoTap = Tap(vec4(0.0f, 0.0f, 0.0f, -1.0f), 0.0f, 0.0f);

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

// Weights without edge-stopping functions compare no surfaces.
bool Counts(float inverse_depth) {
  return kWeights == kAtrousNaive || inverse_depth > 0.0f;
}

// Taps are addressed by `d`, in steps from the pixel p.
#ifdef STILLRAY_TILE
const int kResidues = kStep % 2 == 0 ? 2 : 1;  // residue classes of a group
const int kTileWidth = (LOCAL_SIZE_X / kResidues + 2 * kRadius) * kResidues;
const int kTileHeight = LOCAL_SIZE_Y + 2 * kRadius;
const int kTexels = kTileWidth * kTileHeight;
shared vec4 tile_surface[kTexels];  // normal, inverse depth
shared uint tile_id[kTexels];
#ifdef STILLRAY_HALF
shared uvec2 tile_light[kTexels * kSignals];  // halves: less shared memory, more groups at a time
#else
shared vec4 tile_light[kTexels * kSignals];
#endif
shared float tile_factor[kTexels * kSignals];
shared float tile_pilot[kPilot != 0 ? kTexels * kSignals : 1];

// The first pixel of the group: that of its first residue class.
ivec2 First() {
  uvec2 classes = uvec2(kStep / kResidues, kStep);
  uvec2 place = gl_WorkGroupID.xy / classes;
  ivec2 residue = ivec2(gl_WorkGroupID.xy - place * classes);
  return ivec2(place) * ivec2(LOCAL_SIZE_X / kResidues, LOCAL_SIZE_Y) * kStep +
         residue * ivec2(kResidues, 1);
}
// The pixel at a column and a row of the tile without its border. Columns go through the classes.
ivec2 PixelAt(ivec2 first, int column, int row) {
  int place = (column + kRadius * kResidues) / kResidues - kRadius;
  return first + ivec2(place * kStep + column - place * kResidues, row * kStep);
}
ivec2 OwnPixel() {
  ivec2 at = ivec2(gl_LocalInvocationID.xy);
  return PixelAt(First(), at.x, at.y);
}
int TexelOf(ivec2 d) {
  ivec2 at = ivec2(gl_LocalInvocationID.xy);
  return (at.y + kRadius + d.y) * kTileWidth + at.x + (kRadius + d.x) * kResidues;
}

const int kInvocations = LOCAL_SIZE_X * LOCAL_SIZE_Y;
const int kLoads = (kTexels + kInvocations - 1) / kInvocations;  // texels of an invocation

// The texel of the tile that the invocation loads as its i-th.
int LoadedTexel(int i) {
  return i * kInvocations + int(gl_LocalInvocationIndex);
}
ivec2 PixelOfTexel(ivec2 first, int texel) {
  int row = texel / kTileWidth;
  return PixelAt(first, texel - row * kTileWidth - kRadius * kResidues, row - kRadius);
}

void StoreTap(int at, Tap tap) {
#ifdef STILLRAY_HALF
  tile_light[at] = uvec2(packHalf2x16(tap.light.xy), packHalf2x16(tap.light.zw));
#else
  tile_light[at] = tap.light;
#endif
  if (kWeights == kAtrousSvgf) {
    tile_factor[at] = tap.factor;
  }
  if (kPilot != 0) {
    tile_pilot[at] = tap.luminance;
  }
}

// All fetches come before their first use, without branches, so that their latencies overlap.
void LoadTile() {
  ivec2 first = First();
  uvec4 surfaces[kLoads];
  uint ids[kLoads];
  Tap taps[kLoads * kSignals];
  [[unroll]] for (int i = 0; i < kLoads; ++i) {
    ivec2 q = ClampToLevel(PixelOfTexel(first, LoadedTexel(i)));
    surfaces[i] = texelFetch(surface_image, q, 0);
    ids[i] = kComparesIds ? FetchId(q) : 0u;
    [[unroll]] for (int s = 0; s < kSignals; ++s) {
      taps[i * kSignals + s] = FetchTap(q, s);
    }
  }
  [[unroll]] for (int i = 0; i < kLoads; ++i) {
    int texel = LoadedTexel(i);
    if (texel < kTexels) {
      bool inside = InLevel(PixelOfTexel(first, texel));
      float inverse_depth = uintBitsToFloat(surfaces[i].x);
      bool counts = inside && Counts(inverse_depth);
      tile_surface[texel] = vec4(UnpackNormal(surfaces[i]), inverse_depth);
      if (kComparesIds) {
        tile_id[texel] = ids[i];
      }
      [[unroll]] for (int s = 0; s < kSignals; ++s) {
        Tap tap = taps[i * kSignals + s];
        tap.light.w = counts ? tap.light.w : -1.0f;
        StoreTap(s * kTexels + texel, tap);
      }
    }
  }
  barrier();
}

// The light of the tile is invalid where there is no surface.
bool CountsAt(Surface surface) {
  return true;
}
Surface SurfaceAt(ivec2 p, ivec2 d) {
  vec4 texel = tile_surface[TexelOf(d)];
  return Surface(texel.w, texel.xyz);
}
uint IdAt(ivec2 p, ivec2 d) {
  return tile_id[TexelOf(d)];
}
Tap TapAt(ivec2 p, ivec2 d, int s) {
  int at = s * kTexels + TexelOf(d);
#ifdef STILLRAY_HALF
  uvec2 halves = tile_light[at];
  vec4 texel = vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
#else
  vec4 texel = tile_light[at];
#endif
  return Tap(texel, HasPilot(s) ? tile_pilot[at] : texel.x,
             kWeights == kAtrousSvgf ? tile_factor[at] : 0.0f);
}
#else
ivec2 OwnPixel() {
  return ivec2(gl_GlobalInvocationID.xy);
}
void LoadTile() {}
bool CountsAt(Surface surface) {
  return Counts(surface.inverse_depth);
}
Surface SurfaceAt(ivec2 p, ivec2 d) {
  ivec2 q = p + d * tap_step;
  return InLevel(q) ? UnpackSurface(texelFetch(surface_image, q, 0)) : Surface(0.0f, vec3(0.0f));
}
uint IdAt(ivec2 p, ivec2 d) {
  ivec2 q = p + d * tap_step;
  return InLevel(q) ? FetchId(q) : 0u;
}
Tap TapAt(ivec2 p, ivec2 d, int s) {
  ivec2 q = p + d * tap_step;
  return InLevel(q) ? FetchTap(q, s) : kNoTap;
}
#endif

// The pixel that the invocation filters.
struct Pixel {
  bool has_surface;  // else its value stays
  TapGeometry geometry;
  float raised_scale;  // by which NormalScale of specular light is above that of other light
  uint id;
};

Pixel LoadPixel(EdgeStopping edges, ivec2 p) {
  Pixel pixel;
  Surface surface = SurfaceAt(p, ivec2(0));
  Detail detail = Detail(vec2(0.0f), 0u);
  float sigma_n = edges.sigma_n;
  float reflected_sigma_n = sigma_n;
  pixel.has_surface = surface.inverse_depth > 0.0f;
  if (pixel.has_surface) {
    detail = UnpackDetail(texelFetch(detail_image, p, 0), surface.inverse_depth);
    if (kCurved && (kWeights == kAtrousGeometry || kWeights == kAtrousSvgf)) {
      float turn2 = texelFetch(turn2_image, ivec3(p, 0), 0).x;
      sigma_n = CurvedSigmaN(edges.sigma_n, turn2, edges.curvature, kLeastCurvedSigmaN);
      reflected_sigma_n =
          CurvedSigmaN(edges.sigma_n, turn2, edges.curvature, kLeastReflectedSigmaN);
    }
  }
  pixel.geometry =
      GeometryOf(edges, kCurved, kPlanes, kPositions, p, surface, detail, sigma_n, float(tap_step));
  pixel.raised_scale = NormalScale(reflected_sigma_n - sigma_n, kCurved);
  pixel.id = detail.id;
  return pixel;
}

// What the luminance weights of a pixel's taps share, for one signal.
struct Luminance {
  float own;           // the pixel's
  float factor;        // see LuminanceFactor; 0: no luminance weight
  float least_factor;  // see LoweredLuminanceFactor
};

Luminance LuminanceOf(Tap own, int s) {
  // A pilot has no value at pixels without light.
  bool compares = IsValid(own.light.w) || !HasPilot(s);
  return Luminance(own.luminance, compares ? own.factor : 0.0f, own.factor / atrous.noise_ratio);
}

// The exponent of 2 of the weights that all signals share, of a tap at an offset in steps.
float SharedExponent2(EdgeStopping edges, TapGeometry own, Surface other, vec2 offset) {
  if (kWeights == kAtrousNaive) {
    return 0.0f;
  }
  if (kWeights == kAtrousEaw) {
    vec3 dn = own.normal - other.normal;
    float distance = 0.0f;  // from the plane, relative to depth
    float exponent2 = 0.0f;
    if (kPositions) {
      exponent2 = -DepthExponent2(edges, kPlanes, true, own, other.inverse_depth, offset);
    } else {
      distance =
          PlaneDepthExponent2(ExpectedAt(own, offset), other.inverse_depth, own.per_inverse_depth);
    }
    return exponent2 - kExponentsOfE * EawExponent(0.0f, dot(dn, dn), distance * distance, 1.0f,
                                                   atrous.eaw_sigma_n, atrous.eaw_sigma_z);
  }
  return GeometryExponent2(edges, kCurved, kPlanes, kPositions, own, other.normal,
                           other.inverse_depth, offset);
}

// What the normal weight of specular light adds to it.
float ReflectedExponent2(Pixel pixel, Surface other) {
  return kWeights == kAtrousSvgf && kCurved
             ? NormalExponent2(dot(pixel.geometry.normal, other.normal), pixel.raised_scale, true)
             : 0.0f;
}

// The exponent of 2 of the luminance weight of q for signal s.
float LuminanceExponent2(Tap own, Luminance l, Tap q, int s) {
  if (kWeights == kAtrousSvgf) {
    return -abs(l.own - q.luminance) * LoweredLuminanceFactor(l.factor, q.factor, l.least_factor);
  }
  if (kWeights == kAtrousEaw) {
    float dl = IsValid(own.light.w) ? abs(own.light.x - q.light.x) : 0.0f;
    return -kExponentsOfE * EawExponent(dl * dl, 0.0f, 0.0f, EawSigma(s), 1.0f, 1.0f);
  }
  return 0.0f;
}

void Store(ivec2 p, int s, vec4 own, vec4 sum, float sum_weight) {
  if (kOutput == kAtrousSums) {
    imageStore(light_out, ivec3(p, s), vec4(sum_weight));
    return;
  }
  // Smaller sums have lost their precision: no neighbour is similar to this pixel.
  bool filled = sum_weight > kMinAtrousWeight;
  float inverse = filled ? 1.0f / sum_weight : 0.0f;
  vec3 c = filled ? sum.xyz * inverse : own.xyz;
  float variance = filled ? sum.w * inverse * inverse : VarianceOf(own.w);
  if (kOutput == kAtrousPilot) {
    imageStore(light_out, ivec3(p, s), Stored(MixPilot(p, s, own, c, variance)));
    return;
  }
  bool valid = IsValid(own.w) || (atrous.grows != 0 && kWeights != kAtrousGeometry && filled);
  imageStore(light_out, ivec3(p, s), Stored(vec4(c, PackDeviation(variance, valid))));
}

void main() {
  LoadTile();
  ivec2 p = OwnPixel();
  if (!InLevel(p)) {
    return;
  }
  EdgeStopping edges = LevelEdges();
  Pixel pixel = LoadPixel(edges, p);
  Tap own[kSignals];
  Luminance luminance[kSignals];
  vec4 sum[kSignals];  // light, variance
  float sum_weight[kSignals];
  bool any = kWeights != kAtrousGeometry;  // else the value is not used
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    own[s] = TapAt(p, ivec2(0), s);
    luminance[s] = LuminanceOf(own[s], s);
    any = any || IsValid(own[s].light.w);
    sum[s] = vec4(0.0f);
    sum_weight[s] = 0.0f;
  }
  if (!pixel.has_surface || !any) {
    PassThrough(p);
    return;
  }
  // Rows in a loop: all taps at once take twice the registers, and do not fit into caches of
  // instructions.
  [[dont_unroll]] for (int y = -kRadius; y <= kRadius; ++y) {
    float row_weight = KernelWeight(y);
    [[unroll]] for (int x = -kRadius; x <= kRadius; ++x) {
      ivec2 d = ivec2(x, y);
      float h = row_weight * KernelWeight(x);
      bool counts = true;
      float exponent2 = 0.0f;  // of the weights that all signals share
      float reflected2 = 0.0f;
      if (kWeights != kAtrousNaive) {
        Surface other = SurfaceAt(p, d);
        bool is_centre = x == 0 && y == 0;
        counts = CountsAt(other) && (!kComparesIds || IdAt(p, d) == pixel.id);
        exponent2 = is_centre ? 0.0f : SharedExponent2(edges, pixel.geometry, other, vec2(d));
        reflected2 = is_centre ? 0.0f : ReflectedExponent2(pixel, other);
      }
      [[unroll]] for (int s = 0; s < kSignals; ++s) {
        Tap q = TapAt(p, d, s);
        // One exponential for all weights of a tap.
        float shared2 = exponent2 + ((atrous.reflected_signals >> s & 1) != 0 ? reflected2 : 0.0f);
        float w = h * exp2(shared2 + LuminanceExponent2(own[s], luminance[s], q, s));
        w = counts && IsValid(q.light.w) ? w : 0.0f;
        float deviation = w * q.light.w;
        sum[s] += vec4(w * q.light.xyz, deviation * deviation);
        sum_weight[s] += w;
      }
    }
  }
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    Store(p, s, own[s].light, sum[s], sum_weight[s]);
  }
}
