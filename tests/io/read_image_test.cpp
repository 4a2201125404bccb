// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::read_image_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(ReadImage, ReadsExrAsItIs) {
  const TempFolder folder;
  ExrImage exr;
  exr.width = 3;
  exr.height = 2;
  Image3 colour(3, 2);
  colour[0](2, 1) = 1000.0f;
  exr.Add("", PixelType::kFloat, colour);
  ASSERT_TRUE(WriteExr(folder.Path("a.exr"), exr).ok());
  bool linear = false;
  const Result<Image3> image = ReadImage(folder.Path("a.exr"), &linear);
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_TRUE(linear);
  EXPECT_EQ((*image)[0](2, 1), 1000.0f);
}

TEST(ReadImage, TheBytesTellTheKindNotTheName) {
  const TempFolder folder;
  ASSERT_TRUE(WritePng(folder.Path("a.exr"), Rgb8Image{1, 1, {255, 0, 0}}).ok());
  bool linear = true;
  const Result<Image3> image = ReadImage(folder.Path("a.exr"), &linear);
  ASSERT_TRUE(image.ok()) << image.status().message();
  EXPECT_FALSE(linear);
  EXPECT_EQ((*image)[0](0, 0), 1.0f);
}

TEST(ReadImage, SaysWhatItCannotRead) {
  const TempFolder folder;
  const Status text = ReadImage(folder.Write("a.txt", "hello")).status();
  EXPECT_EQ(text.code(), StatusCode::kUnsupported);
  EXPECT_THAT(text.message(), AllOf(HasSubstr("a.txt"), HasSubstr("EXR, HDR, PNG, JPEG")));
  const Status empty = ReadImage(folder.Write("b.png", "")).status();
  EXPECT_EQ(empty.code(), StatusCode::kBadData);
  EXPECT_THAT(empty.message(), AllOf(HasSubstr("b.png"), HasSubstr("empty")));
  EXPECT_EQ(ReadImage(folder.Path("none.exr")).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(ReadImage(folder.Path("")).status().code(), StatusCode::kIo);
}

TEST(ReadImage, ExrWithoutColourNamesItsChannels) {
  const TempFolder folder;
  ExrImage exr;
  exr.width = 1;
  exr.height = 1;
  exr.Add("depth.Z", PixelType::kFloat, Image1(1, 1));
  ASSERT_TRUE(WriteExr(folder.Path("a.exr"), exr).ok());
  const Status status = ReadImage(folder.Path("a.exr")).status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), AllOf(HasSubstr("a.exr"), HasSubstr("depth.Z")));
}

}  // namespace
}  // namespace stillray::read_image_test
