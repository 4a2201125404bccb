// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text.h"

namespace stillray::io {

std::string OneLine(std::string_view text, size_t max_size) {
  std::string line(text.substr(0, max_size));
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      c = ' ';
    }
  }
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) {
    line.pop_back();
  }
  return line;
}

}  // namespace stillray::io
