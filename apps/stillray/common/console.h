// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Text for the user on standard output and standard error. No failure to write it ends a run: that
/// of standard error is ignored, that of standard output is reported when all work is done.
#pragma once

#include <cstdio>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "core/printable.h"

namespace stillray {

/// Writes text as it is. Never throws.
void WriteText(std::FILE* stream, std::string_view text);

/// A value of a message: text with its control characters escaped, all else as it is.
template <typename Value>
auto MessageValue(const Value& value) {
  if constexpr (std::is_convertible_v<const Value&, std::string_view>) {
    return Printable(value, std::string_view::npos);
  } else {
    return value;
  }
}

/// fmt::print, without its exception where the stream cannot be written. Text among the values may
/// come from files and command lines: it can neither end the line nor steer a terminal. WriteText
/// is for text of several lines.
template <typename... Values>
void PrintTo(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) {
  const auto print = [&](const auto&... shown) {
    WriteText(stream, fmt::vformat(format, fmt::make_format_args(shown...)));
  };
  print(MessageValue(values)...);
}

/// Gives /dev/null to standard streams that the caller closed, before any file is opened: else a
/// file of a run would get the number of one, and messages for the user would go into it. Writing
/// to them still fails.
void OccupyClosedStreams();

/// Flushes standard output.
/// \return why text for it was lost (an error number); 0 if none was, or where the caller of the
///         program had closed it
int OutputError();

}  // namespace stillray
