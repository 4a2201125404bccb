// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Stores a device's results for a batch of pixels in the planes of a frame.
#pragma once

#include "render/frame_store.h"
#include "render/vulkan/trace_shared.h"

namespace stillray::render {

PixelGuides GuidesOf(const GpuGuides& guides);
SampleLight LightOf(const GpuPixelLight& light);

/// The part of a rectangular batch that lies within the picture.
Tile TileOf(const GpuBatch& batch, int width, int height);

/// Stores guides of a rectangular batch, and the sums of `spp` samples of light, in the order of
/// the batch; null: not stored.
void StoreBatch(const GpuBatch& batch, const GpuGuides* guides, const GpuPixelLight* sums, int spp,
                Frame* frame);

/// Stores the mean of `spp` samples of a reference.
void StoreReference(const GpuBatch& batch, const GpuPixelLight* sums, int spp, Image3* radiance);

}  // namespace stillray::render
