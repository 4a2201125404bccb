// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Progress of a run over many frames: a bar with the time left on a terminal, plain lines
/// elsewhere.
#pragma once

#include <cstdio>
#include <string>

#include "core/clock.h"

namespace stillray {

/// "12 s", "3 min 05 s", "2 h 10 min".
std::string FormatDuration(double seconds);

class Progress {
 public:
  /// \param total   units of work, > 0, in any unit
  /// \param stream  where to write; a terminal gets the bar
  Progress(double total, std::FILE* stream);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Records the progress, and redraws the bar, a few times per second at most.
  void Update(double done, const std::string& what);
  /// Reports a finished step: prints its line, except on a terminal, which shows only the bar.
  void Step(double done, const std::string& line);
  /// Erases the bar, so that other text can be written.
  void Clear();

 private:
  std::string TimeLeft() const;
  void Draw(const std::string& what);

  double total_;
  std::FILE* stream_;
  bool terminal_;
  bool drawn_ = false;
  /// Steps may be reported late, while the next one is running: neither the bar nor the remaining
  /// time moves backwards.
  double most_done_ = 0;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_draw_;
};

}  // namespace stillray
