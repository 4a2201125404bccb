// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Numbers of samples per pixel in files of Cycles: the pass Debug Sample Count holds fractions of
/// the number in the attribute cycles.ViewLayer.samples. Measured with Blender 3.4.1: without
/// adaptive sampling the pass is 1 everywhere, else n / samples as a 32-bit float.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// Whether the layer holds fractions rather than numbers of samples.
bool HoldsFractions(const AovSource& samples);

/// The attribute with the number of samples to which the fractions refer:
/// "cycles.ViewLayer.samples", with the name of the layer's view layer, or the default name
/// "ViewLayer" if the layer has no prefix, as in files of the File Output node.
std::string SamplesAttribute(const AovSource& samples);

/// The number of samples per pixel of the layer's view layer; 0 if the file does not state it.
int CyclesSamples(const ExrImage& image, const AovSource& samples);

/// The maximum of the samples per pixel of all view layers ("cycles.ViewLayer.samples"); 0:
/// unknown.
int StatedSamples(const ExrImage& image);

/// round(fraction * samples), at least 1; 0 (missing) unless the fraction is > 0.
void ToCounts(int samples, Image1* fractions);

/// Drops a layer of fractions whose number of samples is unknown, with a note.
void DecideSamples(const ExrImage& image, AovLayout* layout);

/// Finds AovLayout::second_moments of the signals in use. They are meaningless without numbers of
/// samples.
void DecideSecondMoments(const ExrImage& image, AovLayout* layout);

}  // namespace stillray::io
