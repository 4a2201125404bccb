// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// sum_albedo: the sum of a surface's albedos and its range, by which antialias separates texture
/// from light. Source: none. The range at a block of 4x4 pixels is that of the pixels of the 3x3
/// blocks around it: 12x12 pixels have nearly every colour of a texture, even where thin lines lie
/// between the rays of a frame. Where mirrors show images, the albedo of reflected light is that of
/// what is seen, and pixels are marked that have another image in this range: what moves in a
/// mirror must not leave a trail of its albedo. Border: 8 pixels. Reads 12 bytes per pixel and
/// albedo, writes 14; with images reads 4 and writes 4 more.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/sum_albedo_shared.h"

namespace stillray {

struct SummedAlbedo {
  Image3 sum;   ///< >= 0; albedos that are not finite count as 0
  Image3 low;   ///< the range, per block
  Image3 high;  ///< likewise
  /// 1 where a pixel shows an image and those around it another one or none, else 0; empty: nowhere
  Image1 beside_image;
  /// Work memory: the ranges of the blocks alone. Border of 1 block, an empty range.
  Image3 block_low;
  Image3 block_high;
  Image1 block_nearest;  ///< of the images; empty until there are some, as the next
  Image1 block_farthest;

  SummedAlbedo() = default;
  /// \param width, height  of the picture, pixels
  SummedAlbedo(int width, int height);
  size_t bytes() const {
    return sum.bytes() + low.bytes() + high.bytes() + beside_image.bytes() + block_low.bytes() +
           block_high.bytes() + block_nearest.bytes() + block_farthest.bytes();
  }
};

/// \param albedos  at least one
/// \param images   depth of the images that pixels show, 0: none (FindImages of picture_motion.h);
///     nullptr: no pixel shows one
namespace reference {
void SumAlbedo(std::span<const Image3* const> albedos, const Image1* images, SummedAlbedo* out);
}  // namespace reference
namespace cpu {
void SumAlbedo(std::span<const Image3* const> albedos, const Image1* images, SummedAlbedo* out);
}  // namespace cpu

}  // namespace stillray
