// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/nearest_names.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace stillray::nearest_names_test {
namespace {

TEST(EditDistance, WorkedByHand) {
  EXPECT_EQ(EditDistance("", ""), 0);
  EXPECT_EQ(EditDistance("abc", ""), 3);
  EXPECT_EQ(EditDistance("", "abc"), 3);
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3);
  EXPECT_EQ(EditDistance("rendr", "render"), 1);
  EXPECT_EQ(EditDistance("redner", "render"), 1);  // neighbours swapped
  EXPECT_EQ(EditDistance("ca", "abc"), 3);         // optimal string alignment edits no part twice
}

TEST(DidYouMean, NamesTheNearest) {
  constexpr std::string_view kNames[] = {"sigma_z", "sigma_n", "sigma_l", "steps", "kernel"};
  EXPECT_EQ(DidYouMean("sigmal", kNames), ", did you mean sigma_l?");
  EXPECT_EQ(DidYouMean("kernal", kNames), ", did you mean kernel?");
  EXPECT_EQ(DidYouMean("sigma", kNames), ", did you mean sigma_z, sigma_n or sigma_l?");
  EXPECT_EQ(DidYouMean("ste", kNames), ", did you mean steps?");
}

TEST(DidYouMean, TakesAnyListOfNames) {
  const std::vector<std::string> strings = {"render", "denoise"};
  const std::vector<const char*> letters = {"render", "denoise"};
  EXPECT_EQ(DidYouMeanOneOf("rendr", strings), ", did you mean render?");
  EXPECT_EQ(DidYouMeanOneOf("denose", letters), ", did you mean denoise?");
  EXPECT_EQ(DidYouMeanOneOf("fly", strings), "");
}

TEST(DidYouMean, SaysNothingOfNamesThatAreFar) {
  constexpr std::string_view kNames[] = {"render", "denoise"};
  EXPECT_EQ(DidYouMean("fly", kNames), "");
  EXPECT_EQ(DidYouMean("", kNames), "");
  EXPECT_EQ(DidYouMean(std::string(10000, 'r'), kNames), "");
  EXPECT_EQ(DidYouMean("render", {}), "");
}

}  // namespace
}  // namespace stillray::nearest_names_test
