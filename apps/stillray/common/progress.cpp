// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "common/console.h"
#include "core/clock.h"

namespace stillray {

std::string FormatDuration(double seconds) {
  const auto whole = static_cast<int64_t>(std::llround(std::max(seconds, 0.0)));
  if (whole < 60) {
    return fmt::format("{} s", whole);
  }
  if (whole < 3600) {
    return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  }
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

Progress::Progress(double total, std::FILE* stream)
    : total_(total), stream_(stream), terminal_(isatty(fileno(stream)) != 0) {}

Progress::~Progress() {
  Clear();
}

std::string Progress::TimeLeft() const {
  const double elapsed = SecondsSince(start_);
  if (!(most_done_ > 0) || elapsed < 1) {
    return "";
  }
  return FormatDuration(elapsed * (total_ - most_done_) / most_done_) + " left";
}

void Progress::Draw(const std::string& what) {
  constexpr int kWidth = 28;
  const int filled = std::clamp(static_cast<int>(kWidth * most_done_ / total_), 0, kWidth);
  const std::string bar = std::string(static_cast<size_t>(filled), '#') +
                          std::string(static_cast<size_t>(kWidth - filled), '.');
  // \33[K clears the remainder of a longer previous line.
  PrintTo(stream_, "\r[{}] {:3.0f} %  {}  {}\33[K", bar, 100 * most_done_ / total_, what,
          TimeLeft());
  std::fflush(stream_);
  drawn_ = true;
  last_draw_ = Clock::now();
}

void Progress::Update(double done, const std::string& what) {
  most_done_ = std::max(done, most_done_);
  if (terminal_ && (!drawn_ || Clock::now() - last_draw_ > std::chrono::milliseconds(150))) {
    Draw(what);
  }
}

void Progress::Step(double done, const std::string& line) {
  most_done_ = std::max(done, most_done_);
  if (terminal_) {
    Draw(line);
    return;
  }
  const std::string left = most_done_ < total_ ? TimeLeft() : "";
  PrintTo(stream_, "{}{}{}\n", line, left.empty() ? "" : ", ", left);
  std::fflush(stream_);
}

void Progress::Clear() {
  if (drawn_) {
    PrintTo(stream_, "\r\33[K");
    std::fflush(stream_);
    drawn_ = false;
  }
}

}  // namespace stillray
