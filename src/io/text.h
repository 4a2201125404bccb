// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Text from files, made safe for messages.
#pragma once

#include <string>
#include <string_view>

namespace stillray::io {

/// At most `max_size` bytes of the text with control characters replaced by blanks, so that it fits
/// on one line and cannot control a terminal; without blanks and dots at its end.
std::string OneLine(std::string_view text, size_t max_size = 1000);

}  // namespace stillray::io
