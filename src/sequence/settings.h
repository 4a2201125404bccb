// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The settings that a sequence is denoised with: the user's, where the files allow them.
#pragma once

#include "stillray/aov.h"
#include "stillray/denoise.hpp"
#include "stillray/io.h"
#include "stillray/sequence.h"

namespace stillray {

/// \param first  the first file of the sequence
Settings SettingsFor(const SequenceOptions& options, const AovLayout& layout,
                     const ExrImage& first);

}  // namespace stillray
