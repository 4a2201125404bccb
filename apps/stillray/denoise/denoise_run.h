// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "denoise/denoise_options.h"

namespace stillray {

/// Denoises all frames, or the remaining frames with --resume, and prints the roles of layers,
/// progress and a summary. Finished files are kept after a failure.
/// \param threads  number of threads, only for the log
Status RunDenoise(const DenoiseOptions& options, int threads);

}  // namespace stillray
