// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Traces the paths of a tile, all in the same step at a time: shading, shadow rays, next hits. The
/// steps are defined in path_shared.h.
#pragma once

#include <array>

#include "render/draw_numbers.h"
#include "render/path_shared.h"
#include "render/primary.h"
#include "stillray/frame.h"
#include "stillray/render.h"

namespace stillray::render {

/// Light of one sample by SignalKind. The last two are zero unless transmitted light is separate.
using SampleLight = std::array<vec3, kMostTracedSignals>;
/// Sums of the squared luminances of samples, likewise.
using SampleSquares = std::array<float, kMostTracedSignals>;

/// A path between two surfaces, with the state that it keeps between steps.
struct Path : PathState {
  PathSampler sampler;
  int pixel;   // of the tile
  bool known;  // the first surface is given to TraceSample
};

/// Memory for the paths of a tile, reused for the next.
struct PathScratch {
  RayScratch trace;
  RayBatch next;
  RayBatch shadow;
  struct ShadowLight {
    int pixel;
    int properties;  // kLight...
    FoundLight light;
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
/// \param first      of the pixels with a single layer, so that they need no second look-up; may be
///     null
/// \param samplers   one per pixel
/// \param separates  by pixel: its transmitted light is separate, see PixelGuides; null: none
void TraceSample(const TraceContext& context, const PrimaryPixel* pixels, const FirstSurface* first,
                 const PathSampler* samplers, const bool* separates, int count,
                 PathScratch* scratch, RenderTimings* timings);

}  // namespace stillray::render
