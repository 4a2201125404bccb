// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/import_log.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace stillray {

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
