// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The settings for denoising a sequence: the user's, as far as the files allow.
#pragma once

#include "stillray/aov.h"
#include "stillray/denoise.hpp"
#include "stillray/io.h"
#include "stillray/sequence.h"

namespace stillray {

/// The weight of a new frame of several samples per pixel in temporal antialiasing: each counts as
/// much as the one sample of a frame whose weight is `alpha`.
/// \param alpha    0 to 1
/// \param samples  above 0
float AntialiasingWeight(float alpha, int samples);

/// \param first       the first file of the sequence
/// \param has_motion  in files, or derived
Settings SettingsFor(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                     bool has_motion);

/// Whether all rays went through the centres of their pixels, and the pictures will not be
/// antialiased. Only in files of renderers whose guides are means over the samples, like the light.
bool HasJaggedEdges(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                    bool has_motion);

/// The number of samples of every pixel of files without a layer of it: SequenceOptions::spp, else
/// what the first file states; 0: unknown, which counts as 1. 1 if the user says samples=none. A
/// number that is wrong, as where Cycles stops early at some pixels, still is better than 1: it
/// scales all histories alike. Presets without limit_history, those of the papers, do not use what
/// files state: their measure of noise, variance_of=frame, is better with 1.
/// \return kInvalidArgument: spp is given for files with a layer
Result<int> SamplesFor(const SequenceOptions& options, const AovLayout& layout,
                       const ExrImage& first, const Settings& settings);

}  // namespace stillray
