// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides of pixels whose depth is that of a sample without a surface, although other samples met
/// one or were scattered: smoke, fog, hair, and edges under a transparent film. Cycles stores the
/// depth of one sample, but means of all other layers. Light without a depth is not filtered.
#pragma once

#include <cstdint>

#include "stillray/frame.h"

namespace stillray::io {

/// Whether any value is below 1. \param alpha  may be empty
bool IsPartlyTransparent(const Image1& alpha);

/// Marks the pixels that have to be given a depth: it is +infinity, but the signals hold light, or
/// the film is covered. Samples that pass a volume, or that it scatters and no light reaches,
/// belong to its mean too: where some pixel shows a volume alone (its samples met no surface),
/// those with background or nothing are marked within two pixels of it, and those with nothing
/// among surfaces.
/// \param frame  with emission and background, and the signals of light passes
/// \param alpha  of the picture, or empty; the film is transparent if any of it is below 1
/// \return 1 where a depth is missing; empty if none is
Plane<uint8_t> FindCoveredWithoutDepth(const Frame& frame, const Image1& alpha);

/// Takes the background behind volumes, which becomes part of a signal: it has the noise of the
/// samples that pass.
/// Between hairs it stays, where its noise and that of the hair's light are opposite: a filter of
/// one of them alone would let the other one show.
/// \param without_depth  as FindCoveredWithoutDepth returns it
/// \param volume         light of volumes
/// \param normal         zero where no sample met a surface
/// \param background     loses what is returned
Image3 TakeBackground(const Plane<uint8_t>& without_depth, const Image3& volume,
                      const Image3& normal, Image3* background);

/// Divides the albedo of pixels that show a volume by the fraction of their samples that met a
/// surface, which the length of the mean normal is where the surface is flat. The albedo of a mean
/// is a mean over all samples, so it has the noise of that fraction; divided by the result, the
/// light has it, and is filtered.
/// \param volume         light of the volume
/// \param stored_normal  means over the samples, zero for those that met no surface
/// \param albedo         [in,out] results are not above 1, unless they were
void DivideByHits(const Image3& volume, const Image3& stored_normal, Image3* albedo);

/// Gives the marked pixels a depth, interpolated from the pixels around that have one (harmonic
/// means over cells of 2x2, 4x4, ... pixels, bilinearly interpolated: Gortler et al. 1996, "The
/// Lumigraph", section 3.4: pull-push), and the id of the first one in the smallest cell. Where no
/// sample met a surface (the normal is zero), normal, motion and albedos are interpolated likewise.
/// Without any depth in the picture, depth is 1, the normal (0, 0, 1) and motion zero.
/// \param marked  of the guides' size
void FillDepth(const Plane<uint8_t>& marked, Guides* guides);

}  // namespace stillray::io
