// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/base64.h"

#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace stillray::base64_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// RFC 4648, section 10, and bytes of the digits behind the letters.
constexpr std::pair<std::string_view, std::string_view> kVectors[] = {
    {"", ""},
    {"f", "Zg=="},
    {"fo", "Zm8="},
    {"foo", "Zm9v"},
    {"foob", "Zm9vYg=="},
    {"fooba", "Zm9vYmE="},
    {"foobar", "Zm9vYmFy"},
    {"\xff\xfe\xfd", "//79"},
};

TEST(Base64, TestVectorsBothWays) {
  for (const auto& [bytes, text] : kVectors) {
    std::string encoded;
    AppendBase64(bytes, &encoded);
    EXPECT_EQ(encoded, text);
    const std::vector<uint8_t> decoded = DecodeBase64(text).value();
    EXPECT_EQ(std::string(decoded.begin(), decoded.end()), bytes);
  }
}

TEST(Base64, PaddingMayBeMissing) {
  EXPECT_THAT(DecodeBase64("AAE").value(), ElementsAre(0, 1));
  EXPECT_THAT(DecodeBase64("AA").value(), ElementsAre(0));
}

TEST(Base64, DamagedTextIsAnError) {
  EXPECT_THAT(DecodeBase64("AAAAA").status().message(), HasSubstr("cut short"));
  EXPECT_THAT(DecodeBase64("AA*A").status().message(), HasSubstr("character 2"));
}

}  // namespace
}  // namespace stillray::base64_test
