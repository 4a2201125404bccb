// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Messages of an import: the first error, and warnings about parts left out or corrected.
#pragma once

#include <string>
#include <vector>

#include "core/printable.h"
#include "stillray/status.h"

namespace stillray {

/// Collects messages. Only the first error is kept: later errors are its consequences. Not
/// thread-safe: parallel tasks write to separate logs, which are appended in a fixed order.
class ImportLog {
 public:
  /// Maximum number of warnings kept; further warnings are only counted.
  static constexpr size_t kMaxWarnings = 100;

  void Fail(Status status);
  /// Adds a warning; duplicates are dropped.
  void Warn(const std::string& text);
  void Append(const ImportLog& other);

  bool ok() const { return status_.ok(); }
  const Status& status() const { return status_; }
  /// Returns the warnings, followed by the number of dropped ones.
  std::vector<std::string> TakeWarnings();

 private:
  Status status_;
  std::vector<std::string> warnings_;
  size_t dropped_ = 0;
};

}  // namespace stillray
