// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// keep_mirrors: what is seen in a mirror keeps this frame's samples where their noise is less than
/// what the filter changed. Histories follow the motion of the mirror's surface, not that of the
/// mirrored image, so that sharp reflections come out blurred and late, although a mirror adds no
/// noise of its own. No paper; the blend is the estimator of James and Stein (1961): the noise of
/// the samples is measured within the frame, from the neighbours that are nearest in luminance
/// (across an edge or along a texture some neighbour is alike, in noise none is), the bias of the
/// filtered light is what its squared difference from the samples exceeds that noise by. Both are
/// means of three geometry-only wavelet levels, as those of limit_history. Pixels whose roughness
/// is above the limit stay as they are, bit for bit. No state. Border: that of these levels. Reads
/// 36, writes 28 bytes per pixel and signal around the wavelet.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/keep_mirrors_shared.h"

namespace stillray {

inline constexpr int kKeepMirrorsLevels = 3;

struct KeepMirrorsInput {
  const NewLight* light;   ///< x, of this frame
  const Image3* filtered;  ///< y, luminance first
  const GuidePlanes* guides;
  const Image1* roughness;  ///< perceptual
  const Image2* motion;     ///< nullptr where there is no history
};

/// MeasureMirrors: luminance of `measured` = squared difference of x and y, red = variance of x,
/// variance = 0; present = 1 where there is a sample in a mirror. Its blue is room to work in.
/// KeepMirrors: blends x into y. \param blurred  what the wavelet made of `measured`; where
/// `present` is 0 it is not read
namespace reference {
void MeasureMirrors(const KeepMirrorsInput& in, const KeepMirrorsParameters& parameters,
                    FilterPlanes* measured, Image1* present);
void KeepMirrors(const FilterPlanes& blurred, const Image1& present, const NewLight& light,
                 Image3* filtered);
}  // namespace reference
namespace cpu {
void MeasureMirrors(const KeepMirrorsInput& in, const KeepMirrorsParameters& parameters,
                    FilterPlanes* measured, Image1* present);
void KeepMirrors(const FilterPlanes& blurred, const Image1& present, const NewLight& light,
                 Image3* filtered);
}  // namespace cpu

}  // namespace stillray
