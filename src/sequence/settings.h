// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The settings for denoising a sequence: the user's settings, adapted to the files.
#pragma once

#include "stillray/aov.h"
#include "stillray/denoise.hpp"
#include "stillray/io.h"
#include "stillray/sequence.h"

namespace stillray {

/// The weight of a new frame of several samples per pixel in temporal antialiasing: each sample
/// counts as much as the single sample of a frame with weight `alpha`.
/// \param alpha    0 to 1
/// \param samples  above 0
float AntialiasingWeight(float alpha, int samples);

/// \param first       the first file of the sequence
/// \param has_motion  in files, or derived
Settings SettingsFor(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                     bool has_motion);

/// Whether all rays passed through the pixel centres, so that the output is not antialiased. Only
/// for renderers whose guides are means over the samples, like the radiance.
bool HasJaggedEdges(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                    bool has_motion);

/// The samples per pixel of files without a layer of sample counts: SequenceOptions::spp, else the
/// number in the first file; 0: unknown, which acts as 1. 1 with the option samples=none. Even a
/// wrong number, as when Cycles stops early at some pixels, is better than 1: it scales all
/// histories alike. Presets without limit_history (those of the papers) ignore the number in the
/// file: their noise estimate, variance_of=frame, is better with 1.
/// \return kInvalidArgument: spp is given for files with a layer
Result<int> SamplesFor(const SequenceOptions& options, const AovLayout& layout,
                       const ExrImage& first, const Settings& settings);

}  // namespace stillray
