// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The three ways in which a glTF names bytes: inline as base64, as a relative file, as neither.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/status.h"

namespace stillray {

bool IsDataUri(std::string_view uri);

/// Decodes "data:[mediatype];base64,..." (RFC 2397, RFC 4648; padding may be missing).
/// \return kBadData that says what is wrong
Result<std::vector<uint8_t>> DecodeDataUri(std::string_view uri);

/// The file that a relative reference (RFC 3986, percent-encoded) means.
/// \param base_folder  folder that the reference starts from; files outside it are refused, so that
///                     a scene cannot make us read what its author only guesses to exist
/// \return kBadData for absolute paths, schemes and paths that leave the folder
Result<std::string> ResolveUri(const std::string& uri, const std::string& base_folder);

/// \return kNotFound, kBadData if it is no ordinary file, kIo
Result<std::vector<uint8_t>> ReadFileBytes(const std::string& path);

}  // namespace stillray
