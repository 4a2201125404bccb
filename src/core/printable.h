// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Text from files and command lines, made safe for messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace stillray {

/// Default limit for one name in a message, in bytes.
inline constexpr size_t kMaxPrintedBytes = 200;

/// The text with control characters (C0, DEL, and C1 in UTF-8) escaped as \n, \t or \x1b, so that a
/// message stays on one line and cannot control a terminal. All other bytes are kept.
/// \param max_bytes  of the text; the rest is replaced by "...", without splitting a UTF-8 sequence
std::string Printable(std::string_view text, size_t max_bytes = kMaxPrintedBytes);

}  // namespace stillray
