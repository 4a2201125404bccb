// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Text for the user on standard output and standard error. A failed write ends no run: on standard
/// error it is ignored, on standard output it is reported when all work is done.
#pragma once

#include <cstdio>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "core/printable.h"

namespace stillray {

/// Writes text unchanged. Never throws.
void WriteText(std::FILE* stream, std::string_view text);

/// A value of a message: text with its control characters escaped, other types unchanged.
template <typename Value>
auto MessageValue(const Value& value) {
  if constexpr (std::is_convertible_v<const Value&, std::string_view>) {
    return Printable(value, std::string_view::npos);
  } else {
    return value;
  }
}

/// fmt::print, without its exception if the stream cannot be written. Text among the values may
/// come from files and command lines: it can neither end the line nor control a terminal. For text
/// of several lines use WriteText.
template <typename... Values>
void PrintTo(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) {
  const auto print = [&](const auto&... shown) {
    WriteText(stream, fmt::vformat(format, fmt::make_format_args(shown...)));
  };
  print(MessageValue(values)...);
}

/// Opens /dev/null for standard streams that the caller closed, before any file is opened:
/// otherwise a file of a run would get the number of one, and messages for the user would go into
/// it. Writing to them still fails.
void OccupyClosedStreams();

/// Flushes standard output.
/// \return the error number if text was lost; 0 if none was, or if the caller of the program had
///     closed it
int OutputError();

}  // namespace stillray
