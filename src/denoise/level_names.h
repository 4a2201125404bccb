// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Names of the wavelet's levels, in timings and outputs.
#pragma once

#include <string_view>

#include "stillray/denoise.hpp"

namespace stillray {

/// "atrous1" for level 0; the string has static storage.
inline const char* LevelName(int level) {
  static constexpr const char* kNames[kMaxLevels] = {"atrous1", "atrous2", "atrous3", "atrous4",
                                                     "atrous5", "atrous6", "atrous7", "atrous8"};
  return kNames[level];
}

/// Whether the name is that of a wavelet level.
inline bool IsLevelName(std::string_view name) {
  return name.starts_with("atrous");
}

}  // namespace stillray
