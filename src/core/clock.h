// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Elapsed wall-clock time.
#pragma once

#include <chrono>

namespace stillray {

using Clock = std::chrono::steady_clock;

inline double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

inline double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Of the clock, from an arbitrary origin.
inline double SecondsNow() {
  return SecondsSince(Clock::time_point());
}

}  // namespace stillray
