// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// sum_albedo: the sum of a surface's albedos and its range, by which antialias separates texture
/// from light. Source: none. The range at a block of 4x4 pixels is that of the pixels of the 3x3
/// blocks around it: 12x12 pixels have nearly every colour of a texture, even where thin lines lie
/// between the rays of a frame. Border: 8 pixels. Reads 12 bytes per pixel and albedo, writes 14.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/sum_albedo_shared.h"

namespace stillray {

struct SummedAlbedo {
  Image3 sum;   ///< >= 0; albedos that are not finite count as 0
  Image3 low;   ///< the range, per block
  Image3 high;  ///< likewise
  /// Work memory: the ranges of the blocks alone. Border of 1 block, an empty range.
  Image3 block_low;
  Image3 block_high;

  SummedAlbedo() = default;
  /// \param width, height  of the picture, pixels
  SummedAlbedo(int width, int height);
  size_t bytes() const {
    return sum.bytes() + low.bytes() + high.bytes() + block_low.bytes() + block_high.bytes();
  }
};

/// \param albedos  at least one
namespace reference {
void SumAlbedo(std::span<const Image3* const> albedos, SummedAlbedo* out);
}  // namespace reference
namespace cpu {
void SumAlbedo(std::span<const Image3* const> albedos, SummedAlbedo* out);
}  // namespace cpu

}  // namespace stillray
