// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// sum_albedo: the sum of a surface's albedos and its range, by which antialias separates texture
/// from radiance. Source: none. The range of a block of 4x4 pixels is taken over the 3x3 blocks
/// around it: 12x12 pixels contain nearly every colour of a texture, even where thin lines lie
/// between the rays of a frame. Where mirrors show virtual images, the albedo of reflected light is
/// that of the reflected surface, and pixels with another virtual image within these blocks are
/// marked: a moving reflection must not leave a trail of its albedo. Border: 8 pixels. Reads 12
/// bytes per pixel and albedo, writes 14; with virtual images reads 4 and writes 4 more.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/sum_albedo_shared.h"

namespace stillray {

struct SummedAlbedo {
  Image3 sum;   ///< >= 0; albedos that are not finite count as 0
  Image3 low;   ///< lower end of the range, per block
  Image3 high;  ///< upper end of the range, per block
  /// 1 where a pixel shows a virtual image and those around it another or none, else 0; empty:
  /// nowhere
  Image1 beside_image;
  /// Work memory: the range of each single block. Border of 1 block, with an empty range.
  Image3 block_low;
  Image3 block_high;
  Image1 block_nearest;  ///< depth range of virtual images; empty until there are some
  Image1 block_farthest;

  SummedAlbedo() = default;
  /// \param width, height  of the image, pixels
  SummedAlbedo(int width, int height);
  size_t bytes() const {
    return sum.bytes() + low.bytes() + high.bytes() + beside_image.bytes() + block_low.bytes() +
           block_high.bytes() + block_nearest.bytes() + block_farthest.bytes();
  }
};

/// \param albedos  at least one
/// \param images   depth of the virtual image at each pixel, 0: none (FindImages of
///     picture_motion.h); nullptr: no pixel has one
namespace reference {
void SumAlbedo(std::span<const Image3* const> albedos, const Image1* images, SummedAlbedo* out);
}  // namespace reference
namespace cpu {
void SumAlbedo(std::span<const Image3* const> albedos, const Image1* images, SummedAlbedo* out);
}  // namespace cpu

}  // namespace stillray
