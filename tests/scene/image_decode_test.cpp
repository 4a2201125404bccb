// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/image_decode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/test_pictures.h"

namespace stillray::image_decode_test {
namespace {

using ::testing::HasSubstr;

TEST(ImageDecode, LosslessFormatsGiveTheTexelsBack) {
  const std::vector<uint8_t> texels = test::TestTexels(6, 5);
  for (const std::vector<uint8_t>& file :
       {test::EncodePng(texels, 6, 5), test::EncodeWebp(texels, 6, 5)}) {
    const Result<ImageInfo> info = InspectImage(file);
    ASSERT_TRUE(info.ok()) << info.status().message();
    EXPECT_EQ(info->width, 6);
    EXPECT_EQ(info->height, 5);
    const Result<std::vector<uint8_t>> decoded = DecodeImage(file, *info);
    ASSERT_TRUE(decoded.ok()) << decoded.status().message();
    EXPECT_EQ(*decoded, texels);
  }
}

TEST(ImageDecode, EveryTruncationIsAnError) {
  const std::vector<uint8_t> texels = test::TestTexels(32, 32);
  for (const std::vector<uint8_t>& file :
       {test::EncodePng(texels, 32, 32), test::EncodeWebp(texels, 32, 32),
        test::EncodeJpeg(texels, 32, 32)}) {
    // Down to half: the last bytes of PNG (after the pixels) may be missing without harm.
    for (size_t size = file.size() / 2; size + 16 < file.size(); size += 7) {
      const std::span<const uint8_t> cut(file.data(), size);
      const Result<ImageInfo> info = InspectImage(cut);
      EXPECT_FALSE(info.ok() && DecodeImage(cut, *info).ok()) << size << " of " << file.size();
    }
  }
}

TEST(ImageDecode, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
  std::vector<uint8_t> png = test::EncodePng(test::TestTexels(4, 4), 4, 4);
  png[16] = 0x7f;
  const Result<ImageInfo> wide = InspectImage(png);
  ASSERT_FALSE(wide.ok());
  EXPECT_EQ(wide.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(wide.status().message(), HasSubstr("at most 16384x16384"));
  png[16] = 0;
  png[18] = 0x40;  // 16388
  EXPECT_FALSE(InspectImage(png).ok());
  png[18] = 0x3f;  // 16132 x 16132 in a hundred bytes
  png[22] = 0x3f;
  const Result<ImageInfo> empty = InspectImage(png);
  ASSERT_FALSE(empty.ok());
  EXPECT_EQ(empty.status().code(), StatusCode::kBadData);
}

TEST(ImageDecode, NoBytesAreNoPicture) {
  EXPECT_FALSE(InspectImage({}).ok());
  const std::vector<uint8_t> start = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  EXPECT_FALSE(InspectImage(start).ok());
}

}  // namespace
}  // namespace stillray::image_decode_test
