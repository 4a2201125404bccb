// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/printable.h"

#include <gtest/gtest.h>

namespace stillray::printable_test {
namespace {

TEST(Printable, EscapesControlCharacters) {
  EXPECT_EQ(Printable("a\nb\tc\r"), "a\\nb\\tc\\r");
  EXPECT_EQ(Printable("\x1b[31mred\x7f"), "\\x1b[31mred\\x7f");
  EXPECT_EQ(Printable(std::string_view("\0", 1)), "\\x00");
  // U+009B, which terminals read as the beginning of an escape sequence.
  EXPECT_EQ(Printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m");
}

TEST(Printable, LeavesAllOtherBytes) {
  EXPECT_EQ(Printable("out/k\xc3\xbc"
                      "che \xff '$(x)'\\"),
            "out/k\xc3\xbc"
            "che \xff '$(x)'\\");
  EXPECT_EQ(Printable("\xc2\xa0"), "\xc2\xa0");
  EXPECT_EQ(Printable("\xc2"), "\xc2");
  EXPECT_EQ(Printable(""), "");
}

TEST(Printable, CutsBetweenCharacters) {
  EXPECT_EQ(Printable("abcd", 4), "abcd");
  EXPECT_EQ(Printable("abcde", 4), "abcd...");
  EXPECT_EQ(Printable("abc\xc3\xbc", 4), "abc...");
}

}  // namespace
}  // namespace stillray::printable_test
