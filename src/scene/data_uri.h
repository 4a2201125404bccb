// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Data referenced by a glTF file: inline base64, or a relative file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/status.h"

namespace stillray {

bool IsDataUri(std::string_view uri);

/// Decodes "data:[mediatype];base64,..." (RFC 2397, RFC 4648; padding may be missing).
/// \return kBadData with the cause
Result<std::vector<uint8_t>> DecodeDataUri(std::string_view uri);

/// Resolves a relative reference (RFC 3986, percent-encoded) to a file path.
/// \param base_folder  folder of the reference; files outside it are rejected, so that a scene
///     cannot read arbitrary files
/// \return kBadData for absolute paths, schemes and paths that leave the folder
Result<std::string> ResolveUri(const std::string& uri, const std::string& base_folder);

/// \return kNotFound, kBadData if it is not a regular file, kIo
Result<std::vector<uint8_t>> ReadFileBytes(const std::string& path);

}  // namespace stillray
