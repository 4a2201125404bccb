// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Copies a device's results for a batch of pixels to the host planes of a frame.
#pragma once

#include "render/frame_store.h"
#include "render/virtual_image.h"
#include "render/vulkan/trace_shared.h"

namespace stillray::render {

PixelGuides GuidesOf(const GpuGuides& guides);
VirtualImage ImageOf(const GpuImage& image);
/// \param first  first signal of a pixel
SampleLight LightOf(const GpuSignal* first, uint32_t signals);

/// The part of a rectangular batch that lies within the image.
Tile TileOf(const GpuBatch& batch, int width, int height);

/// Results of a batch, in the order of its pixels; null: not stored.
struct BatchResults {
  const GpuGuides* guides = nullptr;
  const GpuImage* reflections = nullptr;
  const GpuImage* refractions = nullptr;
  const GpuSignal* sums = nullptr;     ///< sums over `spp` samples
  uint32_t signals = kSurfaceSignals;  ///< number of signals per pixel
  int spp = 1;
};

/// Stores the results of a rectangular batch.
void StoreBatch(const GpuBatch& batch, const BatchResults& results, Frame* frame);

/// Stores the mean radiance over the `spp` samples of a reference.
void StoreReference(const GpuBatch& batch, const GpuSignal* sums, int spp, Image3* radiance);

}  // namespace stillray::render
