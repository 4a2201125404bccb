// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/denoise_options.h"

namespace stillray {

/// Denoises all frames of the options, or the remaining ones with --resume, and prints the roles of
/// layers, progress and a summary. Finished files stay if it fails.
/// \param threads  for the log only
Status RunDenoise(const DenoiseOptions& options, int threads);

}  // namespace stillray
