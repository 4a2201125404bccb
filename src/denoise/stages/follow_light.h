// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// follow_light: the ratio of the filtered radiance of this frame to that of the last frame, by
/// which antialias multiplies its previous output. Without the ratio the previous output, a mean
/// over about eight frames, lags behind moving or changing lights, and the clamp of antialias, made
/// for edges, lets most of the lag pass. Source: none.
///
/// The diffuse signals are compared along the motion of the surface, at one pixel of each block of
/// 4x4, demodulated, so that textures have no effect. Pixels that move with a reflection, or with
/// another surface within three pixels, are not compared. The change is the mean over those of the
/// 5x5 blocks around that show the same surface, reduced by their noise (FollowedChange); next to
/// another surface the ratio is 1, since it is interpolated between blocks. Border: 2 blocks.
/// State: the last frame's radiance per block. Reads 9 and writes 3 bytes per pixel.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/follow_light_shared.h"
#include "denoise/stages/remodulate.h"

namespace stillray {

struct FollowLightInput {
  PictureParts parts;
  size_t followed_signals = 0;  ///< number of `parts.signals` that are compared, from the first:
                                ///< AntialiasParameters::follow_light
  const Image2& motion;
  const Image2& picture_motion;  ///< motion of visible reflections, elsewhere of surfaces
  const GuidePlanes& guides;
  const Image1& length;             ///< history length of the first signal, this frame included
  const Image1* samples = nullptr;  ///< of this frame; nullptr: one sample everywhere
  const Image1* before = nullptr;   ///< radiance of the last frame per block; nullptr: none
};

/// Work memory: one pixel per block, with a border of kFollowRadius blocks without surface.
struct FollowedBlocks {
  Image1 change;  ///< LogChange
  Image1 known;   ///< 1: known, 0: no surface, or a newly visible one
  Image1 inverse_depth;
  Image3 normal;
  Image2 gradient;  ///< of inverse depth, per pixel
  Plane<uint32_t> id;

  FollowedBlocks() = default;
  /// \param width, height  of the image, pixels
  FollowedBlocks(int width, int height);
  size_t bytes() const {
    return change.bytes() + known.bytes() + inverse_depth.bytes() + normal.bytes() +
           gradient.bytes() + id.bytes();
  }
};

/// The part that both versions share: reads one pixel in sixteen, and the depths beside it.
/// \param now  [out] the radiance of this frame per block; must not be `in.before`
void CompareBlocks(const FollowLightInput& in, FollowedBlocks* blocks, Image1* now);

/// \param ratio  [out] per block
namespace reference {
void FollowLight(const FollowedBlocks& blocks, Image1* ratio);
}  // namespace reference
namespace cpu {
void FollowLight(const FollowedBlocks& blocks, Image1* ratio);
}  // namespace cpu

/// The ratio at a row of pixels, interpolated between blocks.
/// \param row  [out] `width` values
void FollowedRow(const Image1& ratio, int y, int width, float* row);

}  // namespace stillray
