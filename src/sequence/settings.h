// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The settings for denoising a sequence: the user's, as far as the files allow.
#pragma once

#include "stillray/aov.h"
#include "stillray/denoise.hpp"
#include "stillray/io.h"
#include "stillray/sequence.h"

namespace stillray {

/// \param first       the first file of the sequence
/// \param has_motion  in files, or derived
Settings SettingsFor(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                     bool has_motion);

}  // namespace stillray
