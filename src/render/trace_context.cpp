// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/trace_context.h"

#include <chrono>

namespace stillray::render {
namespace {

int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

PhaseTimer::PhaseTimer(double* sum_ms) : sum_ms_(sum_ms), start_ns_(NowNs()) {}

PhaseTimer::~PhaseTimer() {
  *sum_ms_ += static_cast<double>(NowNs() - start_ns_) * 1e-6;
}

}  // namespace stillray::render
