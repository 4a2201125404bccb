// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Text for the user on standard output and standard error. Failed writes do not abort a run: on
/// standard error they are ignored, on standard output they are reported at the end.
#pragma once

#include <cstdio>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "core/printable.h"

namespace stillray {

/// Writes text unchanged. Never throws.
void WriteText(std::FILE* stream, std::string_view text);

/// Sanitises a value of a message: escapes control characters in text, leaves other types
/// unchanged.
template <typename Value>
auto MessageValue(const Value& value) {
  if constexpr (std::is_convertible_v<const Value&, std::string_view>) {
    return Printable(value, std::string_view::npos);
  } else {
    return value;
  }
}

/// fmt::print without exceptions on write errors. Control characters in text values, which may come
/// from files and command lines, are escaped: values can neither end the line nor control a
/// terminal. For multi-line text use WriteText.
template <typename... Values>
void PrintTo(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) {
  const auto print = [&](const auto&... shown) {
    WriteText(stream, fmt::vformat(format, fmt::make_format_args(shown...)));
  };
  print(MessageValue(values)...);
}

/// Opens /dev/null for standard streams that the caller closed, before any file is opened:
/// otherwise a later output file would get the descriptor of a standard stream, and messages would
/// be written to the file. Writing to the streams still fails.
void OccupyClosedStreams();

/// Flushes standard output.
/// \return errno if text was lost; 0 if not, or if the stream was closed at program start
int OutputError();

}  // namespace stillray
