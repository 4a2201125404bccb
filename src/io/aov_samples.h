// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Numbers of samples per pixel as Cycles states them: its pass Debug Sample Count holds fractions
/// of the number in the attribute cycles.ViewLayer.samples. Measured with Blender 3.4.1: without
/// adaptive sampling the pass is 1 everywhere, else n / samples as a 32-bit float.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// Whether the layer holds fractions rather than numbers of samples.
bool HoldsFractions(const AovSource& samples);

/// The attribute with the number of samples that these are fractions of:
/// "cycles.ViewLayer.samples", with the name of the layer's view layer; "ViewLayer", the usual
/// name, if the layer has none, as those of the File Output node.
std::string SamplesAttribute(const AovSource& samples);

/// The number of samples per pixel of the layer's view layer; 0 if the file does not state it.
int CyclesSamples(const ExrImage& image, const AovSource& samples);

/// The samples per pixel that Cycles states for a view layer ("cycles.ViewLayer.samples"), the most
/// of all view layers; 0: unknown.
int StatedSamples(const ExrImage& image);

/// round(fraction * samples) and at least 1; 0, missing, where the fraction is not above 0.
void ToCounts(int samples, Image1* fractions);

/// Drops a layer of fractions whose number of samples is unknown, with a note.
void DecideSamples(const ExrImage& image, AovLayout* layout);

/// Finds AovLayout::second_moments of the light that is read. Without numbers of samples they have
/// no meaning.
void DecideSecondMoments(const ExrImage& image, AovLayout* layout);

}  // namespace stillray::io
