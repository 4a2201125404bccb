// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Structs of older and newer headers than the library's.
#include <cstring>

#include <gmock/gmock.h>

#include "capi/calls.h"
#include "capi/capi_frames.h"

namespace stillray::test::structs_test {
namespace {

using testing::HasSubstr;

struct StructsTest : testing::Test {
  DenoiserHandle denoiser = MakeDenoiser();
  std::string Message() const { return stillray_error_message(denoiser.get()); }
  void SetUp() override {
    CallerFrame caller(MakeBusyFrame(16, 12, 0));
    caller.Run(denoiser.get());
  }
};

TEST_F(StructsTest, ASizeThatWasNotSetIsRefused) {
  stillray_statistics statistics = {};
  EXPECT_EQ(stillray_denoiser_statistics(denoiser.get(), &statistics),
            STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(Message(), "statistics->struct_size is 0, expected sizeof(stillray_statistics)");
  statistics.struct_size = 0x7fff12345678u;  // memory that was not initialised
  EXPECT_EQ(stillray_denoiser_statistics(denoiser.get(), &statistics),
            STILLRAY_ERROR_INVALID_ARGUMENT);
  stillray_input_info info = {};
  EXPECT_EQ(stillray_input_at(0, &info), STILLRAY_ERROR_INVALID_ARGUMENT);
  EXPECT_STREQ(stillray_error_message(nullptr),
               "info->struct_size is 0, expected sizeof(stillray_input_info)");
  stillray_parameter parameter = {};
  EXPECT_EQ(stillray_parameter_at(0, &parameter), STILLRAY_ERROR_INVALID_ARGUMENT);
}

TEST_F(StructsTest, AnOlderStructGetsTheMembersThatItHas) {
  stillray_statistics whole = STILLRAY_STATISTICS_INIT;
  ASSERT_EQ(stillray_denoiser_statistics(denoiser.get(), &whole), STILLRAY_OK);
  stillray_statistics statistics;
  std::memset(&statistics, 0x5a, sizeof(statistics));
  statistics.struct_size = offsetof(stillray_statistics, memory_bytes);
  ASSERT_EQ(stillray_denoiser_statistics(denoiser.get(), &statistics), STILLRAY_OK);
  EXPECT_EQ(statistics.struct_size, offsetof(stillray_statistics, memory_bytes));
  EXPECT_EQ(statistics.non_finite, whole.non_finite);
  EXPECT_EQ(statistics.bad_guides, whole.bad_guides);
  EXPECT_EQ(statistics.memory_bytes, 0x5a5a5a5a5a5a5a5au);  // beyond the caller's struct
}

TEST_F(StructsTest, ANewerStructGetsZerosInWhatIsUnknown) {
  struct Newer {
    stillray_statistics known;
    int64_t more[2];
  } newer = {STILLRAY_STATISTICS_INIT, {7, 7}};
  newer.known.struct_size = sizeof(newer);
  ASSERT_EQ(stillray_denoiser_statistics(denoiser.get(), &newer.known), STILLRAY_OK);
  EXPECT_GT(newer.known.memory_bytes, 0u);
  EXPECT_EQ(newer.known.struct_size, sizeof(newer));
  EXPECT_EQ(newer.more[0], 0);
  EXPECT_EQ(newer.more[1], 0);
}

/// An argument of some later version.
struct Argument {
  size_t struct_size;
  int32_t width;
  int32_t height;
};
struct NewerArgument {
  Argument known;
  int32_t more;
  int32_t padding;
};

TEST(ReadStructTest, MembersThatAnOlderHeaderLacksAreZero) {
  const Argument given = {offsetof(Argument, height), 5, 77};
  Argument read = {};
  ASSERT_TRUE(capi::ReadStruct(&given, "argument", "Argument", &read).ok());
  EXPECT_EQ(read.width, 5);
  EXPECT_EQ(read.height, 0);
}

TEST(ReadStructTest, AMemberThatTheLibraryLacksMustBeZero) {
  NewerArgument given = {{sizeof(NewerArgument), 5, 6}, 0, 0};
  Argument read = {};
  ASSERT_TRUE(capi::ReadStruct(&given.known, "argument", "Argument", &read).ok());
  EXPECT_EQ(read.height, 6);
  given.more = 1;
  const Status status = capi::ReadStruct(&given.known, "argument", "Argument", &read);
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_EQ(status.message(),
            "argument sets what this library does not have: Argument has 24 bytes there, 16 here");
}

}  // namespace
}  // namespace stillray::test::structs_test
