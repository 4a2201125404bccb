// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Chooses the layers of a frame's radiance, and the albedo that divides it.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// Maximum difference between the sum of the passes and the colour due to rounding to halves, as a
/// fraction of the colour; a larger difference is radiance missing in the passes.
inline constexpr float kRoundingPart = 0.01f;

/// Whether the AOV is one component of the radiance, not the sum.
bool IsLight(Aov aov);
/// The albedo layer by which divided radiance must be multiplied.
Aov AlbedoOf(Aov light);
/// The name of the layer of an AOV, at most 60 characters; empty: no layer.
std::string LayerNameOf(const AovLayout& layout, Aov aov);
void Drop(Aov aov, AovLayout* layout);

/// Decides whether the radiance is read from passes or from the colour alone, and drops the layers
/// that are not needed.
/// \return kNotFound if neither is available
Status DecideLight(const std::string& file, AovLayout* layout);

/// Chooses the albedo for radiance that is one signal.
void DecideFallbackAlbedo(const AovOptions& options, AovLayout* layout);

/// Drops a colour that is already denoised while its passes are noisy: it is not their sum. A
/// colour named by --aov is kept.
void DecideColour(const ExrImage& image, const AovOptions& options, const std::string& file,
                  AovLayout* layout);

/// Chooses the signal for the remainder, colour minus passes. It is noisy if passes of reflection,
/// transmission or further lobes (coat, sheen) are missing.
void DecideRest(AovLayout* layout);

}  // namespace stillray::io
