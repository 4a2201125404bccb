// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Lower case, for comparing file extensions.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

namespace stillray {

/// ASCII letters in lower case, independent of the locale.
inline std::string LowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

/// The extension of a path with its dot, in lower case.
inline std::string LowerExtension(const std::filesystem::path& path) {
  return LowerCase(path.extension().string());
}

}  // namespace stillray
