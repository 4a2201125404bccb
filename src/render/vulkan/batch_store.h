// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Stores a device's results for a batch of pixels in the planes of a frame.
#pragma once

#include "render/frame_store.h"
#include "render/virtual_image.h"
#include "render/vulkan/trace_shared.h"

namespace stillray::render {

PixelGuides GuidesOf(const GpuGuides& guides);
VirtualImage ImageOf(const GpuImage& image);
/// \param first  of a pixel's signals
SampleLight LightOf(const GpuSignal* first, uint32_t signals);

/// The part of a rectangular batch that lies within the picture.
Tile TileOf(const GpuBatch& batch, int width, int height);

/// Results of the pixels of a batch, in its order; null: not stored.
struct BatchResults {
  const GpuGuides* guides = nullptr;
  const GpuImage* reflections = nullptr;
  const GpuImage* refractions = nullptr;
  const GpuSignal* sums = nullptr;     ///< of `spp` samples
  uint32_t signals = kSurfaceSignals;  ///< of each pixel
  int spp = 1;
};

/// Stores results of a rectangular batch.
void StoreBatch(const GpuBatch& batch, const BatchResults& results, Frame* frame);

/// Stores the mean of `spp` samples of a reference.
void StoreReference(const GpuBatch& batch, const GpuSignal* sums, int spp, Image3* radiance);

}  // namespace stillray::render
