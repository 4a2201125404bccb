// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Names of outputs; see ListSequence in stillray/sequence.h.
#pragma once

#include <string>

namespace stillray {

/// Whether an output is a folder: it ends in a slash, exists as a folder, or is not the name of an
/// image, a video or a sequence.
bool IsFolderName(const std::string& output);

}  // namespace stillray
