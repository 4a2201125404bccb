// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Text from files in messages.
#pragma once

#include <string>
#include <string_view>

namespace stillray::io {

/// At most `max_size` bytes of the text with a blank in place of every control character, so that
/// whatever a file holds makes one line and cannot steer a terminal; without blanks and dots at its
/// end.
std::string OneLine(std::string_view text, size_t max_size = 1000);

}  // namespace stillray::io
