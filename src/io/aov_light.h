// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Of which layers the light of a frame is made, and what it is divided by.
#pragma once

#include <string>

#include "stillray/aov.h"

namespace stillray::io {

/// A layer of light of its own kind, not the sum.
bool IsLight(Aov aov);
/// The colour layer that divided light must be multiplied by.
Aov AlbedoOf(Aov light);
void Drop(Aov aov, AovLayout* layout);

/// Whether all of the light can be had from passes, or only from the sum; what is not needed goes.
/// \return kNotFound where there is neither
Status DecideLight(const std::string& file, AovLayout* layout);

/// What light that is one signal is divided by.
void DecideFallbackAlbedo(const AovOptions& options, AovLayout* layout);

/// A colour that is clean already, beside noisy passes, is not what the passes add up to, and is
/// left out. A colour that was named by --aov is wanted as it is.
void DecideColour(const ExrImage& image, const AovOptions& options, const std::string& file,
                  AovLayout* layout);

/// Where light goes that the colour has and no pass names. Passes of reflection or transmission
/// that are not there leave noisy light over; so do lobes that other renderers have (coat, sheen).
void DecideRest(AovLayout* layout);

}  // namespace stillray::io
