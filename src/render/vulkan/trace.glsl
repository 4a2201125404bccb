// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The state of a batch of pixels, in descriptor set 2. Needs scene.glsl, lights.glsl, path_shared.h
// and sampler_shared.h.
#include "render/lens_guides_shared.h"
#include "render/vulkan/trace_shared.h"

layout(std140, set = 2, binding = 0) uniform FrameBlock {
  GpuFrame frame;
};
layout(std430, set = 2, binding = 1) buffer Paths {
  GpuPath paths[];
};
layout(std430, set = 2, binding = 2) buffer Rays {
  GpuRay rays[];
};
layout(std430, set = 2, binding = 3) buffer Hits {
  GpuHit hits[];
};
layout(std430, set = 2, binding = 4) buffer Shadows {
  GpuShadow shadows[];
};
// Both lists of active paths, each with as many elements as the batch.
layout(std430, set = 2, binding = 5) buffer Lists {
  uint lists[];
};
layout(std430, set = 2, binding = 6) buffer Queues {
  GpuQueue queues[kQueueCount];
  GpuProgress progress;
  GpuCounters counters;
};
layout(std430, set = 2, binding = 7) buffer Guides {
  GpuGuides guides[];
};
layout(std430, set = 2, binding = 8) buffer FirstHits {
  GpuHit first_hits[];
};
layout(std430, set = 2, binding = 9) buffer LightOfSamples {
  GpuSignal sample_lights[];
};
layout(std430, set = 2, binding = 10) buffer Sums {
  GpuSignal sums[];
};
// Positions of listed pixels: x in the lower 16 bits, y in the upper.
layout(std430, set = 2, binding = 11) readonly buffer Listed {
  uint listed_pixels[];
};
// Instance and primitive of the nearest triangle per pixel; kNoInstance: none.
layout(std430, set = 2, binding = 12) readonly buffer Visible {
  uvec2 visible[];
};
// With a lens: sums of the samples' guides per pixel.
layout(std430, set = 2, binding = 13) buffer LensSums {
  LensGuides lens_sums[];
};

// Only with virtual guides: reflections of all pixels, then refractions if transmitted light is
// separate.
layout(std430, set = 2, binding = 14) buffer Images {
  GpuImage images[];
};

layout(std430, set = 2, binding = 15) buffer PathRests {
  GpuPathParts path_parts[];
};

layout(push_constant) uniform Push {
  GpuBatch batch;
};

#include "render/vulkan/batch.glsl"

// Whether paths of an earlier part are unfinished: a later submission repeats the remaining work,
// including the current dispatch.
bool IsStopped() {
  return progress.left > 0u;
}

bool IsInPicture(uvec2 pixel) {
  return pixel.x < frame.width && pixel.y < frame.height;
}

// Index of the first refraction in images.
uint FirstRefraction() {
  return uint(images.length() / 2);
}

// Index of a pixel's first signal in sample_lights and sums.
uint FirstSignal(uint number) {
  return number * frame.signal_count;
}

uint SeedOf(uvec2 pixel) {
  return SamplerSeed(frame.sampler_kind, frame.stream_seed, pixel.x, pixel.y, batch.window_low,
                     batch.window_high);
}

vec4 NumbersOf(uint seed, uint set) {
  return PathNumbers(frame.sampler_kind, batch.sample_index, seed, set);
}

uint ListStart(uint parity) {
  return parity * uint(lists.length() / 2);
}
