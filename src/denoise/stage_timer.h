// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/clock.h"
#include "stillray/denoise.hpp"

namespace stillray {

/// Adds its lifetime to the time of the stage of that name.
class StageTimer {
 public:
  StageTimer(std::vector<StageTime>* times, const char* name) : times_(times), name_(name) {}
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  ~StageTimer() {
    const double elapsed = MillisecondsSince(start_);
    const auto at = std::find_if(times_->begin(), times_->end(),
                                 [&](const StageTime& t) { return t.name == name_; });
    if (at == times_->end()) {
      times_->push_back({name_, elapsed});
    } else {
      at->milliseconds += elapsed;
    }
  }

 private:
  std::vector<StageTime>* times_;
  const char* name_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace stillray
