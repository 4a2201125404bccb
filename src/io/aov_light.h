// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Chooses the layers that make up a frame's light, and the albedo that divides it.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// Sums of passes differ from the colour by the rounding of halves, at most by this fraction of it;
/// a larger difference is light that no pass holds.
inline constexpr float kRoundingPart = 0.01f;

/// Whether the AOV is one kind of light, not the sum.
bool IsLight(Aov aov);
/// The colour layer by which divided light must be multiplied.
Aov AlbedoOf(Aov light);
/// The name of the layer that an AOV is read from, at most 60 characters; empty: none.
std::string LayerNameOf(const AovLayout& layout, Aov aov);
void Drop(Aov aov, AovLayout* layout);

/// Decides whether all light is available as passes, or only as the sum, and drops the layers that
/// are not needed.
/// \return kNotFound if neither is available
Status DecideLight(const std::string& file, AovLayout* layout);

/// Chooses the albedo that divides light that comes as one signal.
void DecideFallbackAlbedo(const AovOptions& options, AovLayout* layout);

/// Drops a colour that is already clean while its passes are noisy: it is not their sum. A colour
/// that --aov names is kept.
void DecideColour(const ExrImage& image, const AovOptions& options, const std::string& file,
                  AovLayout* layout);

/// Chooses the signal for light that is in the colour but in no pass. Missing passes of reflection
/// or transmission leave noisy light over; so do lobes of other renderers (coat, sheen).
void DecideRest(AovLayout* layout);

}  // namespace stillray::io
