// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Structures shared by the host and the path tracing shaders: constants of a frame, a batch of its
// pixels, and the state of each pixel of the batch (layout std430).
#ifndef STILLRAY_RENDER_VULKAN_TRACE_SHARED_H
#define STILLRAY_RENDER_VULKAN_TRACE_SHARED_H

#ifdef __cplusplus
#include "render/lens_guides_shared.h"
#include "render/lens_shape_shared.h"
#include "render/path_shared.h"
#include "render/vulkan/scene_shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct GpuFrame {
  GpuView view;
  GpuView previous;
  vec2 point;  // position of primary rays in the pixel: (0.5, 0.5) is the centre
  uint width;
  uint height;
  uint sampler_kind;  // kSampler...
  uint stream_seed;   // argument of PixelSeed
  int bounces;
  int regularise;
  int ends_are_opaque;  // see TraceContext
  int spread_points;    // 1: each sample has its own position in the pixel
  int with_squares;     // 1: squared luminances of the samples are summed
  int rasterised;       // 1: primary hits are rasterised, in `visible`
  LensShape lens_shape;
  uint lens_mask;      // offset of the lens mask's sums in the words
  int light_sampling;  // kSample...
  int light_candidates;
  float clamp_radiance;
  uint signal_count;  // per pixel: kSurfaceSignals, or kAllSignals if transmitted light is separate
  int shows_reflection;  // 1: reflections have virtual guides
  int filters_textures;  // 1: FiltersTextures; 0 in references
  uint filtered_images;  // virtual images per pixel that keep mean base colours: 0, 1 or 2
};

// Pixels that are traced together: a rectangle of the image in blocks of 8x8, which may extend
// beyond the image, or a list of pixels. Push constants.
struct GpuBatch {
  int x;
  int y;
  int width;  // a multiple of 8
  uint count;
  uint listed;        // 1: the pixels are those of the list
  uint sample_index;  // index of PathNumbers
  uint window_low;    // argument of PixelSeed
  uint window_high;
  uint phase;  // kPhase...
  uint part;   // part of the paths, see StartPart
};

const uint kBlockSize = 8u;

// Position of pixel `number` in a rectangle: block by block, rows of blocks first.
SHARED_FN uint BlockNumber(uint number) {
  return number / (kBlockSize * kBlockSize);
}
SHARED_FN uint ColumnInBatch(uint width, uint number) {
  return BlockNumber(number) % (width / kBlockSize) * kBlockSize + number % kBlockSize;
}
SHARED_FN uint RowInBatch(uint width, uint number) {
  return BlockNumber(number) / (width / kBlockSize) * kBlockSize + number / kBlockSize % kBlockSize;
}
// Inverse of BlockNumber: the number of the pixel at a position.
SHARED_FN uint NumberInBatch(uint width, uint column, uint row) {
  uint block = row / kBlockSize * (width / kBlockSize) + column / kBlockSize;
  return (block * kBlockSize + row % kBlockSize) * kBlockSize + column % kBlockSize;
}

// Device version of PixelGuides; depth is +infinity without a surface.
struct GpuGuides {
  vec3 normal;
  float depth;
  vec3 albedo;
  float roughness;
  vec3 specular_albedo;
  uint id;
  vec3 emission;
  float motion_x;
  vec3 background;
  float motion_y;
  vec3 previous_normal;  // only for deformed instances
  uint colour_low;       // SetColour: the mean base colour at which paths start
  vec3 transmission_albedo;
  uint colour_high;  // 0: none
};

// Number of steps of the components of packed colours, 2^21 - 1: they are exact to 2.4e-7.
const float kColourSteps = 2097151.0f;

// Packs a colour of 0..1 into the guides.
SHARED_FN void SetColour(SHARED_INOUT(GpuGuides) guides, vec3 colour) {
  vec3 steps = min(colour, vec3(1.0f)) * kColourSteps + vec3(0.5f);
  uint green = uint(steps.y);
  guides.colour_low = uint(steps.x) | green << 21;
  guides.colour_high = green >> 11 | uint(steps.z) << 10 | 0x80000000u;
}

SHARED_FN vec3 UnpackColour(uint low, uint high) {
  uint green = low >> 21 | (high & 0x3ffu) << 11;
  return vec3(float(low & 0x1fffffu), float(green), float(high >> 10 & 0x1fffffu)) / kColourSteps;
}

// PixelGuides::separates_transmission.
SHARED_FN bool SeparatesTransmission(SHARED_IN(GpuGuides) guides) {
  return guides.transmission_albedo != vec3(0.0f);
}

// Device version of VirtualImage. Paths read the second half: instance (`id` - 1), primitive,
// barycentric coordinates and mean base colour of the image's surface.
struct GpuImage {
  vec3 normal;
  float depth;
  vec3 albedo;
  float motion_x;
  vec3 base_colour;
  uint primitive;  // kNoPrimitive: no path ends at the image, or it has no surface
  float u;
  float v;
  uint id;
  float motion_y;
};
const uint kNoPrimitive = 0xffffffffu;

// A signal of a pixel: radiance and, in sums over samples, the sum of squared luminances. Each
// pixel has GpuFrame::signal_count signals, by SignalKind.
struct GpuSignal {
  vec3 light;
  float square;
};

// The members of PathState that every step reads and writes.
struct GpuPath {
  vec3 throughput;
  float density;
  vec3 origin;
  float light_total;
  vec3 normal;
  float roughest;
  uint counts;  // from the lowest bit: step (16), bounces (16)
  uint state;   // free_events (8), first (8), light (8), 1: has a medium
  uint seed;
  uint unused_0;
};

// The remaining members: first-surface throughput, which is written once, and the current medium.
struct GpuPathParts {
  vec3 diffuse;
  float unused_0;
  vec3 specular;
  float unused_1;
  vec3 extinction;
  int collisions;
  vec3 scatter_albedo;
  float scatter_anisotropy;
};

// Contribution of light sampling, added if the shadow ray is unoccluded.
struct GpuShadow {
  vec3 origin;
  float end;
  vec3 direction;
  uint pixel;  // index of the pixel in the batch
  vec3 diffuse;
  int light;  // kLight...
  vec3 specular;
  uint unused_0;
};

// A queue of pixels with work: the workgroup count of an indirect dispatch, then the size of an
// indirect ray tracing launch, `count` x 1 x 1.
struct GpuQueue {
  uint groups_x;
  uint groups_y;
  uint groups_z;
  uint count;
  uint rows;
  uint layers;
  uint unused_0, unused_1;
};

// Two queues of paths alternate, and two queues of shadow rays.
const uint kQueueActive = 0u;
const uint kQueueShadow = 2u;
const uint kQueueCount = 4u;
const uint kGroupSize = 64u;

// Progress of the paths, kept from one submission to the next.
struct GpuProgress {
  uint left;   // unfinished paths after the last recorded step, which must be finished first
  uint steps;  // steps of the current part of a sample so far
};

// Counters of a submission.
struct GpuCounters {
  uint primary_rays;
  uint bounce_rays;
  uint shadow_rays;
  uint dropped;  // contributions that were not finite or negative
  uint image_rays;
  uint parts;  // finished parts of samples (GpuBatch::part)
  uint steps;  // most steps of any part
  uint left;   // GpuProgress::left
};

// These values replace Hit::instance of a primary ray that passes transparent surfaces: several
// layers, or a single layer, whose other hit members are valid and whose instance is in the guides.
const uint kSeveralLayers = 0xfffffffeu;
const uint kLayerBeforeSky = 0xfffffffdu;

// Values of GpuBatch::phase. In steps: the index, 0 or 1, of the current queue. Between steps: the
// index of the queue plus
const uint kPhaseMayStop = 4u;  // in the last recorded step: paths may be unfinished
const uint kPhaseEnd = 8u;      // in the last possible step of a path
const uint kPhaseResume = 16u;  // when resuming, of the queue with the unfinished paths
// or
const uint kPhaseStart = 2u;  // after paths have started
// When summing samples.
const uint kPhaseFirstSample = 0u;
const uint kPhaseNextSample = 1u;

STILLRAY_RENDER_END

#ifdef __cplusplus
namespace stillray::render {
static_assert(sizeof(GpuFrame) == 256);
static_assert(sizeof(LensGuides) == 112);
static_assert(sizeof(GpuPath) == 64);
static_assert(sizeof(GpuPathParts) == 64);
static_assert(kMaxFreeEvents + 1 < 256);
static_assert(sizeof(GpuGuides) == 112);
static_assert(sizeof(GpuImage) == 64);
static_assert(sizeof(GpuSignal) == 16);
static_assert(sizeof(GpuShadow) == 64);
static_assert(sizeof(GpuQueue) == 32);
static_assert(sizeof(GpuBatch) <= 128);
}  // namespace stillray::render
#endif

#endif  // STILLRAY_RENDER_VULKAN_TRACE_SHARED_H
