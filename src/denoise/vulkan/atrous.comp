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

layout(constant_id = 1) const int kWeights = kAtrousSvgf;
layout(constant_id = 2) const int kRadius = 2;
layout(constant_id = 3) const int kSignals = 1;
layout(constant_id = 5) const int kCompared = 0;  // 1: a level of limit_history, on the coarse grid
layout(constant_id = 6) const int kSumsOnly = 0;  // 1: writes the sums of weights, for an output
layout(constant_id = 4) const int kPilot = 0;     // bit s: weights of signal s compare the pilot
layout(constant_id = 7) const int kEdgeKinds = 0;  // STILLRAY_ATROUS_...: kinds of weights
#ifdef STILLRAY_TILE
layout(constant_id = 8) const int kResidues = 1;  // residue classes of a group; divides the step
#endif

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
// SharedLuminanceFactor lowers a pixel's own factor to this at least: the same for all taps.
float LeastFactor(Tap own) {
  return own.factor / atrous.noise_ratio;
}
// Outside the picture: no light.
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

// Taps are addressed by `d`, in steps from the pixel p.
#ifdef STILLRAY_TILE
const int kTileWidth = (LOCAL_SIZE_X / kResidues + 2 * kRadius) * kResidues;
const int kTileHeight = LOCAL_SIZE_Y + 2 * kRadius;
const int kTexels = kTileWidth * kTileHeight;
shared vec4 tile_surface[kTexels];  // normal, inverse depth; 0: no surface, or outside
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
  ivec2 classes = ivec2(tap_step / kResidues, tap_step);
  ivec2 group = ivec2(gl_WorkGroupID.xy);
  ivec2 place = group / classes * ivec2(LOCAL_SIZE_X / kResidues, LOCAL_SIZE_Y);
  return place * tap_step + group % classes * ivec2(kResidues, 1);
}
// The pixel at a column and a row of the tile without its border. Columns go through the classes.
ivec2 PixelAt(ivec2 first, int column, int row) {
  int place = (column + kRadius * kResidues) / kResidues - kRadius;
  return first + ivec2(place * tap_step + column - place * kResidues, row * tap_step);
}
ivec2 OwnPixel() {
  ivec2 at = ivec2(gl_LocalInvocationID.xy);
  return PixelAt(First(), at.x, at.y);
}
int TexelOf(ivec2 d) {
  ivec2 at = ivec2(gl_LocalInvocationID.xy);
  return (at.y + kRadius + d.y) * kTileWidth + at.x + (kRadius + d.x) * kResidues;
}

void LoadTexel(ivec2 first, int texel) {
  int row = texel / kTileWidth;
  ivec2 q = PixelAt(first, texel - row * kTileWidth - kRadius * kResidues, row - kRadius);
  bool inside = InLevel(q);
  Surface surface = Surface(0.0f, vec3(0.0f));
  if (inside) {
    surface = UnpackSurface(texelFetch(surface_image, q, 0));
    tile_id[texel] = kComparesIds ? FetchId(q) : 0u;
  }
  tile_surface[texel] = vec4(surface.normal, surface.inverse_depth);
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    int at = s * kTexels + texel;
    Tap tap = kNoTap;
    if (inside) {
      tap = FetchTap(q, s);
    }
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
}
void LoadTile() {
  ivec2 first = First();
  for (int texel = int(gl_LocalInvocationIndex); texel < kTexels;
       texel += LOCAL_SIZE_X * LOCAL_SIZE_Y) {
    LoadTexel(first, texel);
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
  Tap tap = kNoTap;
  if (InLevel(q)) {
    tap = FetchTap(q, s);
  }
  return tap;
}
#endif

// The exponent of 2 of the luminance weight of q for signal s.
float LuminanceExponent2(Tap own, float least_factor, Tap q, int s) {
  if (kWeights == kAtrousSvgf) {
    float dl = IsValid(own.light.w) || !HasPilot(s) ? abs(own.luminance - q.luminance) : 0.0f;
    return -dl * LoweredLuminanceFactor(own.factor, q.factor, least_factor);
  }
  if (kWeights == kAtrousEaw) {
    float dl = IsValid(own.light.w) ? abs(own.light.x - q.light.x) : 0.0f;
    return -kExponentsOfE * EawExponent(dl * dl, 0.0f, 0.0f, EawSigma(s), 1.0f, 1.0f);
  }
  return 0.0f;
}

// The pixel that the invocation filters.
struct Centre {
  ivec2 p;
  bool has_surface;  // else its value stays
  TapGeometry geometry;
  uint id;
};

Centre CentreOf(EdgeStopping edges, ivec2 p) {
  Centre centre;
  centre.p = p;
  Surface surface = SurfaceAt(p, ivec2(0));
  Detail detail = Detail(vec2(0.0f), 0u);
  float sigma_n = edges.sigma_n;
  centre.has_surface = InLevel(p) && surface.inverse_depth > 0.0f;
  if (centre.has_surface) {
    detail = UnpackDetail(texelFetch(detail_image, p, 0), surface.inverse_depth);
    if (kCurved && (kWeights == kAtrousGeometry || kWeights == kAtrousSvgf)) {
      float turn2 = Turn2At(edges, surface_image, surface.normal, p);
      sigma_n = CurvedSigmaN(edges.sigma_n, turn2, edges.curvature);
    }
  }
  centre.geometry =
      GeometryOf(edges, kPlanes, kPositions, p, surface, detail, sigma_n, float(tap_step));
  centre.id = detail.id;
  return centre;
}

// The exponent of 2 of the weights that all signals share, of a tap at an offset in steps.
float SharedExponent2(EdgeStopping edges, Centre centre, Surface other, vec2 offset) {
  if (kWeights == kAtrousEaw && kPositions) {
    vec3 dn = centre.geometry.normal - other.normal;
    return -kExponentsOfE * EawExponent(0.0f, dot(dn, dn), 0.0f, 1.0f, atrous.eaw_sigma_n, 1.0f) -
           DepthExponent2(edges, kPlanes, kPositions, centre.geometry, other.inverse_depth, offset);
  }
  if (kWeights == kAtrousEaw) {
    float expected = centre.geometry.inverse_depth + dot(centre.geometry.gradient, offset);
    float distance =
        PlaneDepthExponent2(expected, other.inverse_depth, centre.geometry.per_inverse_depth);
    vec3 dn = centre.geometry.normal - other.normal;
    return -kExponentsOfE * EawExponent(0.0f, dot(dn, dn), distance * distance, 1.0f,
                                        atrous.eaw_sigma_n, atrous.eaw_sigma_z);
  }
  return GeometryExponent2(edges, kCurved, kPlanes, kPositions, centre.geometry, other.normal,
                           other.inverse_depth, offset);
}

void Store(Centre centre, Tap own, vec4 sum, float sum_weight, int s) {
  if (kSumsOnly != 0) {
    imageStore(light_out, ivec3(centre.p, s), vec4(sum_weight));
    return;
  }
  // Smaller sums have lost their precision: no neighbour is similar to this pixel.
  bool filled = sum_weight > kMinAtrousWeight;
  float inverse = filled ? 1.0f / sum_weight : 0.0f;
  vec3 c = filled ? sum.xyz * inverse : own.light.xyz;
  float variance = filled ? sum.w * inverse * inverse : VarianceOf(own.light.w);
  bool valid = IsValid(own.light.w) || (atrous.grows != 0 && kWeights != kAtrousGeometry && filled);
  imageStore(light_out, ivec3(centre.p, s), Stored(vec4(c, PackDeviation(variance, valid))));
}

void main() {
  LoadTile();
  ivec2 p = OwnPixel();
  EdgeStopping edges = LevelEdges();
  Centre centre = CentreOf(edges, p);
  Tap own[kSignals];
  vec4 sum[kSignals];  // light, variance
  float sum_weight[kSignals];
  float least_factor[kSignals];
  bool any = kWeights != kAtrousGeometry;  // else the value is not used
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    own[s] = TapAt(p, ivec2(0), s);
    least_factor[s] = LeastFactor(own[s]);
    any = any || IsValid(own[s].light.w);
    sum[s] = vec4(0.0f);
    sum_weight[s] = 0.0f;
  }
  if (!InLevel(p)) {
    return;
  }
  if (!centre.has_surface || !any) {
    PassThrough(p);
    return;
  }
  // Rows in a loop, since all taps at once would not fit into caches of instructions.
  [[dont_unroll]] for (int y = -kRadius; y <= kRadius; ++y) {
    float row_weight = KernelWeight(y);
    [[unroll]] for (int x = -kRadius; x <= kRadius; ++x) {
      ivec2 d = ivec2(x, y);
      float h = row_weight * KernelWeight(x);
      bool counts = true;
      float exponent2 = 0.0f;  // of the weights that all signals share
      if (kWeights != kAtrousNaive) {
        Surface other = SurfaceAt(p, d);
        bool is_centre = x == 0 && y == 0;
        counts = other.inverse_depth > 0.0f && (!kComparesIds || IdAt(p, d) == centre.id);
        exponent2 = is_centre ? 0.0f : SharedExponent2(edges, centre, other, vec2(d));
      }
      [[unroll]] for (int s = 0; s < kSignals; ++s) {
        Tap q = TapAt(p, d, s);
        // One exponential for all weights of a tap.
        float w = h * exp2(exponent2 + LuminanceExponent2(own[s], least_factor[s], q, s));
        w = counts && IsValid(q.light.w) ? w : 0.0f;
        float deviation = w * q.light.w;
        sum[s] += vec4(w * q.light.xyz, deviation * deviation);
        sum_weight[s] += w;
      }
    }
  }
  [[unroll]] for (int s = 0; s < kSignals; ++s) {
    Store(centre, own[s], sum[s], sum_weight[s], s);
  }
}
