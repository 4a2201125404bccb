// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/run_summary.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/progress.h"

namespace stillray {
namespace {

/// Formats a duration; short durations have one decimal: "3.2 s".
std::string SecondsText(double seconds) {
  constexpr double kShort = 59.95;
  return seconds < kShort ? fmt::format("{:.1f} s", seconds) : FormatDuration(seconds);
}

/// "denoised.0012.exr" as "denoised.####.exr"; names without a number are unchanged.
std::string PatternOf(const std::string& name) {
  const size_t extension = name.rfind('.');
  const size_t number =
      extension == 0 || extension == std::string::npos ? extension : name.rfind('.', extension - 1);
  if (number == std::string::npos || number + 1 >= extension ||
      !std::all_of(name.begin() + static_cast<ptrdiff_t>(number) + 1,
                   name.begin() + static_cast<ptrdiff_t>(extension),
                   [](char c) { return c >= '0' && c <= '9'; })) {
    return name;
  }
  return name.substr(0, number) + ".####" + name.substr(extension);
}

std::string Frames(size_t count) {
  return fmt::format("{} frame{}", count, count == 1 ? "" : "s");
}

}  // namespace

std::string FormatBytes(int64_t bytes) {
  constexpr const char* kUnits[] = {"kB", "MB", "GB", "TB"};
  constexpr double kStep = 1000;
  if (bytes < 1000) {
    return fmt::format("{} bytes", bytes);
  }
  double value = static_cast<double>(bytes) / kStep;
  size_t unit = 0;
  // 999.5 would be formatted as 1000.
  while (value >= 999.5 && unit + 1 < std::size(kUnits)) {
    value /= kStep;
    ++unit;
  }
  return fmt::format("{:.{}f} {}", value, value < 9.95 ? 1 : 0, kUnits[unit]);
}

std::string RunSummaryText(const RunSummary& summary) {
  const std::string folder = summary.place.empty()          ? "./"
                             : summary.place.ends_with('/') ? summary.place
                                                            : summary.place + "/";
  std::string text = fmt::format("wrote {} to {} ({}) in {}", Frames(summary.frames), folder,
                                 FormatBytes(summary.bytes), SecondsText(summary.seconds));
  if (summary.frames > 0) {
    text += fmt::format(", {:.{}f} ms per frame",
                        1000 * summary.seconds / static_cast<double>(summary.frames),
                        1000 * summary.seconds < 10 * static_cast<double>(summary.frames) ? 1 : 0);
  }
  if (summary.frames_before > 0) {
    text += fmt::format("; {} {} there already", Frames(summary.frames_before),
                        summary.frames_before == 1 ? "was" : "were");
  }
  return text;
}

std::string FilePatternsText(const std::vector<std::string>& names) {
  std::vector<std::string> patterns;
  for (const std::string& name : names) {
    std::string pattern = PatternOf(name);
    if (std::find(patterns.begin(), patterns.end(), pattern) == patterns.end()) {
      patterns.push_back(std::move(pattern));
    }
  }
  return fmt::format("{}", fmt::join(patterns, ", "));
}

Status StopError(const StoppedRun& run) {
  const bool cancelled = run.status.code() == StatusCode::kCancelled;
  if (cancelled && !run.save_status.ok()) {
    return run.save_status;
  }
  std::string message = cancelled ? "stopped" : run.status.message();
  if (run.finished > 0 || cancelled) {
    message += fmt::format("; {} of {} frames are finished", run.finished, run.frames);
  }
  if (!run.resumes_from.empty()) {
    message += ", --resume goes on from " + run.resumes_from;
  } else if (!run.save_status.ok()) {
    message += "; the state for --resume could not be saved either";
  }
  return Status(run.status.code(), message);
}

int64_t FileBytes(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return error ? 0 : static_cast<int64_t>(size);
}

}  // namespace stillray
