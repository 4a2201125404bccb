// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

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

std::string Progress::TimeLeft(double done) const {
  const std::chrono::duration<double> elapsed = Clock::now() - start_;
  if (!(done > 0) || elapsed.count() < 1) {
    return "";
  }
  return FormatDuration(elapsed.count() * (total_ - done) / done) + " left";
}

void Progress::Draw(double done, const std::string& what) {
  constexpr int kWidth = 28;
  most_done_ = done = std::max(done, most_done_);
  const int filled = std::clamp(static_cast<int>(kWidth * done / total_), 0, kWidth);
  const std::string bar = std::string(static_cast<size_t>(filled), '#') +
                          std::string(static_cast<size_t>(kWidth - filled), '.');
  // \33[K clears what a longer line left behind.
  fmt::print(stream_, "\r[{}] {:3.0f} %  {}  {}\33[K", bar, 100 * done / total_, what,
             TimeLeft(done));
  std::fflush(stream_);
  drawn_ = true;
  last_draw_ = Clock::now();
}

void Progress::Update(double done, const std::string& what) {
  if (terminal_ && (!drawn_ || Clock::now() - last_draw_ > std::chrono::milliseconds(150))) {
    Draw(done, what);
  }
}

void Progress::Step(double done, const std::string& line) {
  if (terminal_) {
    Draw(done, line);
    return;
  }
  const std::string left = done < total_ ? TimeLeft(done) : "";
  fmt::print(stream_, "{}{}{}\n", line, left.empty() ? "" : ", ", left);
  std::fflush(stream_);
}

void Progress::Clear() {
  if (drawn_) {
    fmt::print(stream_, "\r\33[K");
    std::fflush(stream_);
    drawn_ = false;
  }
}

}  // namespace stillray
