// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The image files of a report: the views and frames in a folder.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray::report {

/// The views of one frame, in the page's order. The others are compared with the last one.
enum View : int { kNoisy, kTemporal, kDenoised, kReference };
inline constexpr int kViewCount = 4;
inline constexpr int kTestViewCount = 3;  ///< all views but the reference
inline constexpr std::array<const char*, kViewCount> kViewNames = {"noisy", "temporal", "denoised",
                                                                   "reference"};

/// Paths of one view of one frame; empty if there is no such file.
struct PictureFiles {
  std::string png;
  std::string exr;
  bool empty() const { return png.empty() && exr.empty(); }
};

using FrameFiles = std::array<PictureFiles, kViewCount>;
/// By frame number.
using SequenceFiles = std::map<int64_t, FrameFiles>;

/// Finds VIEW.NUMBER.png and VIEW.NUMBER.exr; ignores all other files.
/// \return kNotFound (no such folder, nothing found), kIo, kBadData (two files of the same view,
///     number and format, such as noisy.1.png and noisy.0001.png)
Result<SequenceFiles> FindSequence(const std::string& folder);

/// The frames of the clean sequence, with the other sequences' files of the same numbers; "": no
/// such sequence.
/// \return errors of FindFrameFiles, naming the sequence's option
Result<SequenceFiles> FindViews(const std::string& noisy, const std::string& clean,
                                const std::string& reference);

/// `count` evenly spread indices of 0..total-1, including the first and the last. For count 1 it is
/// the last: temporal filters need frames to converge.
std::vector<int> SpreadEvenly(int total, int count);

/// "noisy, denoised and reference"
std::string JoinNames(const std::vector<std::string>& names);

}  // namespace stillray::report
