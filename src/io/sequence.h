// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Finds the files of a sequence on disk from the name given by the user.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/status.h"

namespace stillray {

struct FrameFile {
  int64_t frame = 0;
  std::string path;
};

/// File extensions, in lower case and with their dot, that match in a folder or by a wild card.
using FileEndings = std::span<const std::string_view>;

/// Whether the file name denotes a sequence: it contains a frame number pattern (see
/// IsFramePattern) or the wild cards '*' and '?'.
bool IsSequenceName(const std::string& path);

/// The name of a sequence to write, with marks in place of wild cards: '*' becomes "####", a run of
/// '?' as many marks. Paths without wild cards, or with marks, are returned unchanged.
std::string AsFramePattern(const std::string& path);

/// The last number in the file name, without its extension; none if there is no digit.
std::optional<int64_t> FrameNumberIn(const std::string& path);

/// The files of one sequence in the order of their frames.
/// \param input  "name.####.exr" or "name.%04d.exr": numbers of that width, or of any width if
///     there are none; "name.*.exr", "name.????.exr": wild cards of a shell; or a folder that holds
///     one sequence. In a name without marks the last number is the frame.
/// \return kNotFound (nothing matches; the message lists the sequences in that folder), kIo,
///     kInvalidArgument (several sequences, or two files of one number, naming them)
Result<std::vector<FrameFile>> FindFrameFiles(const std::string& input, FileEndings endings);

}  // namespace stillray
