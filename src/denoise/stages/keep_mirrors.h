// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// keep_mirrors: reflections keep this frame's samples where their noise is smaller than the error
/// of the filter. Histories follow the motion of the mirror's surface, not of the reflected image,
/// so that sharp reflections are blurred and lag, although a mirror adds no noise. Source: none;
/// the blend is the estimator of James and Stein (1961): the variance of the samples is measured
/// within the frame, from the neighbours that are nearest in luminance (across an edge or along a
/// texture some neighbour is similar, in noise none is); the squared bias of the filtered signal is
/// the excess of its squared difference from the samples over that variance. Both are means of
/// three geometry-only wavelet levels, as in limit_history. Pixels whose roughness is above the
/// limit stay unchanged, bit for bit. No state. Border: as for these levels. Reads 36, writes 28
/// bytes per pixel and signal around the wavelet.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/keep_mirrors_shared.h"

namespace stillray {

struct KeepMirrorsInput {
  const NewLight* light;       ///< x, of this frame
  const LumaImage3* filtered;  ///< y, luminance first
  const GuidePlanes* guides;
  const Image1* roughness;  ///< perceptual
  const Image2* motion;     ///< nullptr without history
};

/// MeasureMirrors: luminance of `measured` = squared difference of x and y, red = variance of x,
/// variance = 0; valid = 1 for samples in mirrors. Its blue is scratch memory. The
/// levels and KeepSamples follow (see keep_samples.h).
namespace reference {
void MeasureMirrors(const KeepMirrorsInput& in, const KeepMirrorsParameters& parameters,
                    FilterPlanes* measured, Image1* valid);
}  // namespace reference
namespace cpu {
void MeasureMirrors(const KeepMirrorsInput& in, const KeepMirrorsParameters& parameters,
                    FilterPlanes* measured, Image1* valid);
}  // namespace cpu

}  // namespace stillray
