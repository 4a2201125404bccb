// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Measured deviations in the reports of tests.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>
#include <string>

namespace stillray::test {

/// Keeps the largest value of this name as a property of the running test, beside its bound.
/// Reports
/// (--gtest_output) then show how near a device comes to the bound: those were chosen on a software
/// driver.
inline void RecordLargest(const std::string& name, double value, double bound) {
  const ::testing::TestInfo* const running =
      ::testing::UnitTest::GetInstance()->current_test_info();
  const ::testing::TestResult* const known = running != nullptr ? running->result() : nullptr;
  for (int i = 0; known != nullptr && i < known->test_property_count(); ++i) {
    const ::testing::TestProperty& property = known->GetTestProperty(i);
    if (property.key() == name && std::atof(property.value()) >= value) {
      return;
    }
  }
  std::ostringstream text;
  text << value << " of " << bound;
  ::testing::Test::RecordProperty(name, text.str());
}

}  // namespace stillray::test
