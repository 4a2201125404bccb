// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace stillray::test {

/// Runs a check on each instruction set that this machine has.
inline void OnEveryTarget(const std::function<void()>& check) {
  for (int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    SCOPED_TRACE(hwy::TargetName(targets & -targets));
    hwy::SetSupportedTargetsForTest(targets & -targets);
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace stillray::test
