// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace stillray::test {

/// Runs a check on each instruction set that this machine has.
inline void OnEveryTarget(const std::function<void()>& check) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace stillray::test
