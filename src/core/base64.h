// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Base64 (RFC 4648, section 4) without line breaks, as in data URIs.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/status.h"

namespace stillray {

/// Appends the text of `bytes` to \p out, padded to a multiple of four characters.
void AppendBase64(std::string_view bytes, std::string* out);

/// \param text  with or without padding
/// \return kBadData naming the invalid character, or if the text is truncated
Result<std::vector<uint8_t>> DecodeBase64(std::string_view text);

}  // namespace stillray
