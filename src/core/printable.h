// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Text of files and command lines in messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace stillray {

/// Of one name in a message.
inline constexpr size_t kMaxPrintedBytes = 200;

/// The text with its control characters (C0, DEL, and C1 in UTF-8) escaped as \n, \t or \x1b, so
/// that a message stays one line and cannot steer a terminal. All other bytes stay as they are.
/// \param max_bytes  of the text; what is cut off leaves "...", no UTF-8 sequence is cut in two
std::string Printable(std::string_view text, size_t max_bytes = kMaxPrintedBytes);

}  // namespace stillray
