// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// follow_light: the ratio of the filtered light to that of the last frame, by which antialias
/// multiplies the last picture. Without it that picture, which counts for the light of eight
/// frames, lags behind a light that moves or changes, and the clamp of antialias, made for edges,
/// lets most of that pass. Source: none.
///
/// The light is compared per surface, along its motion, at one pixel of each block of 4x4, without
/// its albedo, so that textures do not count, of the signals of diffuse light, and not where the
/// picture moves with a reflection or another surface is within three pixels. The change is the
/// mean over the 5x5 blocks around as far as they show the same surface, and is followed as far as
/// it exceeds their noise (FollowedChange); next to another surface it is not followed, since the
/// ratio is interpolated over pixels. Border: 2 blocks. State: the last frame's light per block.
/// Reads 9 and writes 3 bytes per pixel.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/follow_light_shared.h"
#include "denoise/stages/remodulate.h"

namespace stillray {

struct FollowLightInput {
  PictureParts parts;
  size_t followed_signals = 0;  ///< the first ones of `parts`: AntialiasParameters::follow_light
  const Image2& motion;
  const Image2& picture_motion;  ///< that of reflections where those are seen
  const GuidePlanes& guides;
  const Image1& length;             ///< of the first signal's history, with this frame
  const Image1* samples = nullptr;  ///< of this frame; nullptr: one everywhere
  const Image1* before = nullptr;   ///< the light of the last frame; nullptr: none
};

/// Work memory: the pixels of blocks, with a border of kFollowRadius blocks without surface.
struct FollowedBlocks {
  Image1 change;  ///< LogChange
  Image1 known;   ///< 1: known, 0: no surface, or a new one
  Image1 inverse_depth;
  Image3 normal;
  Image2 gradient;  ///< of inverse depth, per pixel
  Plane<uint32_t> id;

  FollowedBlocks() = default;
  /// \param width, height  of the picture, pixels
  FollowedBlocks(int width, int height);
  size_t bytes() const {
    return change.bytes() + known.bytes() + inverse_depth.bytes() + normal.bytes() +
           gradient.bytes() + id.bytes();
  }
};

/// The part that both versions share: one pixel in sixteen is read, and the depths beside it.
/// \param now  [out] the light of this frame per block, another plane than `in.before`
void CompareBlocks(const FollowLightInput& in, FollowedBlocks* blocks, Image1* now);

/// \param ratio  [out] per block
namespace reference {
void FollowLight(const FollowedBlocks& blocks, Image1* ratio);
}  // namespace reference
namespace cpu {
void FollowLight(const FollowedBlocks& blocks, Image1* ratio);
}  // namespace cpu

/// The ratio at a row of pixels, interpolated between the pixels of blocks.
/// \param row  [out] `width` values
void FollowedRow(const Image1& ratio, int y, int width, float* row);

}  // namespace stillray
