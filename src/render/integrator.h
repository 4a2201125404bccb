// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Follows the paths of a tile, all by the same step at a time: shade, test shadows, next hit.
///
/// At every surface light is sought both by a ray to a light and by the scattered ray, weighted by
/// multiple importance sampling (Veach 1997). What the first surface does with light is kept apart
/// for its diffuse and specular lobes: the path beyond carries one weight for each.
#pragma once

#include <array>

#include "render/draw_numbers.h"
#include "render/primary.h"
#include "stillray/frame.h"
#include "stillray/render.h"

namespace stillray::render {

/// Events that do not count as bounces (ideally smooth glass, surfaces passed) end here.
inline constexpr int kMaxFreeEvents = 24;
/// Path-space regularisation (SVGF, section 3; after Kaplanyan and Dachsbacher 2013): GGX alpha of
/// a surface is at least this times the largest mean alpha of the surfaces before it on the path,
/// where a surface's mean is taken over its lobes by their share of light and diffuse counts as 1.
/// Ideally smooth thin sheets are left as they are.
inline constexpr float kRegularisation = 0.3f;

/// Light of one sample by SignalKind.
using SampleLight = std::array<vec3, kTracedSignalCount>;

/// A path between two surfaces.
struct Path {
  PathSampler sampler;
  vec3 throughput;  // beyond the first surface
  vec3 diffuse;     // weights that the first surface's lobes give the light beyond it
  vec3 specular;
  vec3 absorption;    // per unit of length, of the solid that the path is in
  vec3 origin;        // where the ray last scattered with a finite density, or left the camera
  vec3 normal;        // shading normal there
  float density;      // of the ray per solid angle; 0: ideally smooth
  float light_total;  // LightChoices::total() there
  float roughest;     // for regularisation
  int pixel;          // in the tile
  int step;           // surfaces met so far
  int bounces;        // of those, the ones that scattered, without the first
  int free_events;
  bool first;   // has not scattered yet
  bool known;   // first, and its surface is among those given to TraceSample
  bool direct;  // light met now comes straight from a light
};

/// Memory for the paths of a tile, reused for the next.
struct PathScratch {
  RayScratch trace;
  RayBatch next;
  RayBatch shadow;
  struct ShadowLight {
    int pixel;
    bool direct;
    vec3 diffuse;
    vec3 specular;
  };
  ShadowLight shadow_light[kBatchCapacity];
  vec3 transmittance[kBatchCapacity];
  Path paths[kBatchCapacity];
  SamplerBatch samplers;
  NumberBatch scatter_numbers;  // of the paths, for this step
  NumberBatch light_numbers;
  SampleLight light[kBatchCapacity];  // by pixel of the tile
};

/// Traces one sample of every pixel into scratch->light (without emission and background).
/// \param first     of the pixels with a single layer, so that it need not be looked up again;
///                  null: it is not known
/// \param samplers  one per pixel
void TraceSample(const TraceContext& context, const PrimaryPixel* pixels, const FirstSurface* first,
                 const PathSampler* samplers, int count, PathScratch* scratch,
                 RenderTimings* timings);

}  // namespace stillray::render
