// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/denoise_options.h"

namespace stillray {

/// Denoises all frames of the options, or the rest of them where --resume says so, and prints what
/// was understood, progress and a summary. What is finished stays when it fails.
/// \param threads  for the log only
Status RunDenoise(const DenoiseOptions& options, int threads);

}  // namespace stillray
