// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// All textures of a scene in one array image, for texture units: shaders need a single descriptor
/// and no optional feature. A border of one texel around each texture, filled by its wrap mode,
/// makes bilinear filtering correct at the edges.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/device.h"
#include "gpu/memory.h"
#include "stillray/scene.h"

namespace stillray::render {

/// Position of the first texel of a texture, inside the border.
struct AtlasPlace {
  uint32_t x = 0;
  uint32_t y = 0;
  uint32_t layer = 0;
};

/// The layout of the atlas; of size 1 if there are no textures.
struct TextureAtlas {
  int width = 1;
  int height = 1;
  int layers = 1;
  std::vector<AtlasPlace> places;  ///< position of each texture
};

/// Places textures in rows, the tallest first, in layers whose size is a multiple of the largest
/// texture's, selected for the smallest total number of texels.
/// \param most_size, most_layers  the device's limits for images
/// \return kUnsupported: the textures do not fit
Result<TextureAtlas> PlanAtlas(const std::vector<Texture>& textures, int most_size,
                               int most_layers);

/// Texel of a texture with its border, RGBA from the lowest byte. \param x, y -1 to width or height
uint32_t BorderedTexel(const Texture& texture, int x, int y);

/// Copies the placed textures to an image of Arena::AddTextures of the atlas's size; waits for
/// completion. Shaders may then read it.
Status UploadAtlas(gpu::Device* device, const std::vector<Texture>& textures,
                   const TextureAtlas& atlas, const gpu::Image& image);

}  // namespace stillray::render
