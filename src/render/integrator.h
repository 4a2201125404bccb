// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Traces the paths of a tile breadth-first: shading, shadow rays and next hits are each computed
/// for all paths. path_shared.h defines these steps.
#pragma once

#include <array>

#include "render/draw_numbers.h"
#include "render/path_shared.h"
#include "render/primary.h"
#include "render/virtual_image.h"
#include "stillray/frame.h"
#include "stillray/render.h"

namespace stillray::render {

/// Radiance of one sample, by SignalKind. The last two entries are zero unless transmitted light is
/// separate.
using SampleLight = std::array<vec3, kMostTracedSignals>;
/// Sums of the samples' squared luminances, by SignalKind.
using SampleSquares = std::array<float, kMostTracedSignals>;

/// A path between two vertices, with the state kept from step to step.
struct Path : PathState {
  PathSampler sampler;
  int pixel;   // index within the tile
  bool known;  // the first surface is an argument of TraceSample
};

/// Buffers for the paths of a tile, reused for the next tile.
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
  NumberBatch scatter_numbers;  // random numbers of the paths for the current step
  NumberBatch light_numbers;
  SampleLight light[kBatchCapacity];  // indexed by the pixel within the tile
};

/// The pixels of which TraceSample traces one sample each.
struct SampledPixels {
  const PrimaryPixel* pixels;
  const PathSampler* samplers;
  /// First surfaces of the pixels with a single layer, which saves their second evaluation; null:
  /// none.
  const FirstSurface* first = nullptr;
  const ImageBatch* images = nullptr;  ///< null: none
  /// Whether a pixel's transmitted light is separate, see PixelGuides; null: no pixel.
  const bool* separates = nullptr;
  int count = 0;
};

/// Traces one sample of every pixel into scratch->light (without emission and background).
void TraceSample(const TraceContext& context, const SampledPixels& sampled, PathScratch* scratch,
                 RenderTimings* timings);

}  // namespace stillray::render
