// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/clock.h"
#include "stillray/denoise.hpp"

namespace stillray {

/// Adds `more` to the entry with its name, or appends it.
inline void AddTime(const StageTime& more, std::vector<StageTime>* times) {
  const auto same = std::find_if(times->begin(), times->end(),
                                 [&](const StageTime& t) { return t.name == more.name; });
  if (same == times->end()) {
    times->push_back(more);
  } else {
    same->milliseconds += more.milliseconds;
  }
}

/// Adds its lifetime to the time of the stage `name`.
class StageTimer {
 public:
  StageTimer(std::vector<StageTime>* times, const char* name) : times_(times), name_(name) {}
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  ~StageTimer() { AddTime({name_, MillisecondsSince(start_)}, times_); }

 private:
  std::vector<StageTime>* times_;
  const char* name_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace stillray
