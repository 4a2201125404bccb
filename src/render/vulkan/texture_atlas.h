// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// All textures of a scene in one array of images, for texture units: shaders need one descriptor,
/// which every device has, and no feature. A border of one texel around each, by its way of
/// wrapping, makes bilinear filtering right at the edges.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/device.h"
#include "gpu/memory.h"
#include "stillray/scene.h"

namespace stillray::render {

/// Where the first texel of a texture is, behind the border.
struct AtlasPlace {
  uint32_t x = 0;
  uint32_t y = 0;
  uint32_t layer = 0;
};

/// Of size 1 if there are no textures.
struct TextureAtlas {
  int width = 1;
  int height = 1;
  int layers = 1;
  std::vector<AtlasPlace> places;  ///< of each texture
};

/// Places textures in rows, the tallest first, in layers whose size is a multiple of the largest
/// one's: the multiples that take the fewest texels in all.
/// \param most_size, most_layers  of an image of the device
/// \return kUnsupported: the textures do not fit
Result<TextureAtlas> PlanAtlas(const std::vector<Texture>& textures, int most_size,
                               int most_layers);

/// Texel of a texture with its border, RGBA from the lowest byte. \param x, y  -1 to the size
uint32_t BorderedTexel(const Texture& texture, int x, int y);

/// Copies the textures that have places into an image of Arena::AddTextures of the atlas's size;
/// waits for completion. Shaders may then read it.
Status UploadAtlas(gpu::Device* device, const std::vector<Texture>& textures,
                   const TextureAtlas& atlas, const gpu::Image& image);

}  // namespace stillray::render
