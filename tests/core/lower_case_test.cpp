// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/lower_case.h"

#include <gtest/gtest.h>

namespace stillray::lower_case_test {
namespace {

TEST(LowerCase, ChangesAsciiLettersAlone) {
  EXPECT_EQ(LowerCase("AbZ[@`{ 09_\xc3\x84\xff"), "abz[@`{ 09_\xc3\x84\xff");
  EXPECT_EQ(LowerCase(""), "");
}

TEST(LowerExtension, IsTheEndingOfTheLastName) {
  EXPECT_EQ(LowerExtension("Shots.V2/Frame.0001.EXR"), ".exr");
  EXPECT_EQ(LowerExtension("Shots.V2/Frame"), "");
  EXPECT_EQ(LowerExtension(".hidden"), "");
}

}  // namespace
}  // namespace stillray::lower_case_test
