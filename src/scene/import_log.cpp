// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/import_log.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace stillray {

namespace {
constexpr size_t kMaxPrintedBytes = 200;
}  // namespace

std::string Printable(const std::string& text) {
  std::string line = text.substr(0, kMaxPrintedBytes);
  for (char& c : line) {
    const unsigned char byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) {
      c = '?';
    }
  }
  if (text.size() > kMaxPrintedBytes) {
    // Not in the middle of a UTF-8 sequence.
    while (!line.empty() && (static_cast<unsigned char>(line.back()) & 0xc0) == 0x80) {
      line.pop_back();
    }
    if (!line.empty() && static_cast<unsigned char>(line.back()) >= 0xc0) {
      line.pop_back();
    }
    line += "...";
  }
  return line;
}

void ImportLog::Fail(Status status) {
  if (status_.ok()) {
    status_ = std::move(status);
  }
}

void ImportLog::Warn(const std::string& text) {
  if (std::find(warnings_.begin(), warnings_.end(), text) != warnings_.end()) {
    return;
  }
  if (warnings_.size() == kMaxWarnings) {
    ++dropped_;
    return;
  }
  warnings_.push_back(text);
}

void ImportLog::Append(const ImportLog& other) {
  Fail(other.status_);
  for (const std::string& warning : other.warnings_) {
    Warn(warning);
  }
  dropped_ += other.dropped_;
}

std::vector<std::string> ImportLog::TakeWarnings() {
  if (dropped_ != 0) {
    warnings_.push_back(fmt::format("{} more warnings of this kind", dropped_));
    dropped_ = 0;
  }
  return std::exchange(warnings_, {});
}

}  // namespace stillray
