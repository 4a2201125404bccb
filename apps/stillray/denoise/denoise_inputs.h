// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Which files `stillray denoise` reads and writes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stillray/sequence.h"
#include "stillray/status.h"

namespace stillray {

/// The files in the order of their frames.
/// \param inputs  one name for FindFrameFiles(), or files
/// \param output  a pattern, a folder, or for one frame a file
/// \param frames  "FIRST-LAST", one number, or empty for all
/// \return kNotFound, kInvalidArgument (a folder with several sequences, frames that are not there,
///         outputs that would overwrite inputs or each other)
Result<std::vector<SequenceFile>> ListSequence(const std::vector<std::string>& inputs,
                                               const std::string& output,
                                               const std::string& frames);

/// Whether an output names a folder: it ends in a slash, is one, or is no name of a picture, a
/// video or a sequence.
bool IsFolderName(const std::string& output);

}  // namespace stillray
