// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/printable.h"

namespace stillray {
namespace {

bool IsContinuation(char c) {
  return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
}

/// Length in bytes of the control character at the start of `text`; 0 if there is none.
size_t ControlBytes(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x20 || first == 0x7f) {
    return 1;
  }
  const bool is_c1 = first == 0xc2 && text.size() > 1 && static_cast<unsigned char>(text[1]) < 0xa0;
  return is_c1 && IsContinuation(text[1]) ? 2 : 0;
}

void AppendEscaped(unsigned char byte, std::string* out) {
  constexpr const char* kDigits = "0123456789abcdef";
  switch (byte) {
    case '\n':
      *out += "\\n";
      return;
    case '\r':
      *out += "\\r";
      return;
    case '\t':
      *out += "\\t";
      return;
    default:
      *out += "\\x";
      *out += kDigits[byte >> 4];
      *out += kDigits[byte & 15];
  }
}

}  // namespace

std::string Printable(std::string_view text, size_t max_bytes) {
  const bool cut = text.size() > max_bytes;
  if (cut) {
    size_t end = max_bytes;
    while (end > 0 && IsContinuation(text[end])) {
      --end;
    }
    text = text.substr(0, end);
  }
  std::string line;
  for (size_t i = 0; i < text.size();) {
    const size_t control = ControlBytes(text.substr(i));
    for (size_t k = 0; k < control; ++k) {
      AppendEscaped(static_cast<unsigned char>(text[i + k]), &line);
    }
    if (control == 0) {
      line += text[i];
    }
    i += control == 0 ? 1 : control;
  }
  return cut ? line + "..." : line;
}

}  // namespace stillray
