// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides of pixels whose depth is infinite, although some samples hit a surface or were scattered:
/// smoke, fog, hair, and edges under a transparent film. Cycles stores the depth of one sample, but
/// means of all other layers. Radiance at pixels without depth would not be filtered.
#pragma once

#include <cstdint>

#include "stillray/frame.h"

namespace stillray::io {

/// Whether any value is below 1. \param alpha  may be empty
bool IsPartlyTransparent(const Image1& alpha);

/// Marks the pixels that need a depth: depth is +infinity, but the signals are not zero, or the
/// alpha of a transparent film is above 0. Samples that pass through a volume, or are scattered in
/// it without receiving light, belong to its mean too: within two pixels of a pixel that shows a
/// volume alone (no sample hit a surface), pixels with background or without radiance are marked
/// too, and pixels without radiance among surfaces.
/// \param frame  with emission and background, and the signals of light passes
/// \param alpha  of the image, or empty; the film is transparent if any value is below 1
/// \return 1 where a depth is missing; empty if no depth is missing
Plane<uint8_t> FindCoveredWithoutDepth(const Frame& frame, const Image1& alpha);

/// Removes the background behind volumes and returns it, to become part of a signal: it has the
/// noise of the samples that pass through. Between hairs the background is kept: its noise and the
/// noise of the hair's radiance cancel, and filtering only one of them would reveal the other.
/// \param without_depth  as FindCoveredWithoutDepth returns it
/// \param volume         light of volumes
/// \param normal         zero where no sample hit a surface
/// \param background     [in,out] the result is subtracted
Image3 TakeBackground(const Plane<uint8_t>& without_depth, const Image3& volume,
                      const Image3& normal, Image3* background);

/// Divides the albedo of pixels with a volume by the fraction of their samples that hit a surface,
/// which is the length of the mean normal if the surface is flat. The mean albedo over all samples
/// has the noise of that fraction; after demodulation with the result, this noise is in the signal,
/// and is filtered.
/// \param volume         light of the volume
/// \param stored_normal  means over the samples, where samples without a surface count as zero
/// \param albedo         [in,out] results are not above 1, unless they were
void DivideByHits(const Image3& volume, const Image3& stored_normal, Image3* albedo);

/// Sets the depth of the marked pixels by interpolation of neighbouring pixels with a depth
/// (pull-push, Gortler et al. 1996, "The Lumigraph", section 3.4: harmonic means over cells of 2x2,
/// 4x4, ... pixels, bilinearly interpolated), and the id to that of the first such pixel in the
/// smallest cell. Where no sample hit a surface (the normal is zero), normal, motion and albedos
/// are interpolated too. If no pixel of the image has a depth, depth is 1, the normal (0, 0, 1) and
/// motion zero.
/// \param marked  of the guides' size
void FillDepth(const Plane<uint8_t>& marked, Guides* guides);

}  // namespace stillray::io
