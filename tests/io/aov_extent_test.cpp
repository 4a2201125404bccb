// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/exr_foreign.h"
#include "io/test_files.h"
#include "stillray/aov.h"

namespace stillray::aov_extent_test {
namespace {

using ::testing::HasSubstr;

Imath::Box2i Box(int x0, int y0, int x1, int y1) {
  return {Imath::V2i(x0, y0), Imath::V2i(x1, y1)};
}

Result<ExrExtent> Measure(const std::string& bytes) {
  return MeasureExr(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size(), "f.exr");
}

std::string BytesOf(const std::string& path) {
  Result<std::string> bytes = ReadWholeFile(path, 1 << 20);
  EXPECT_TRUE(bytes.ok());
  return bytes.ok() ? std::move(bytes.value()) : std::string();
}

TEST(AovExtent, TheLargerWindowOfAllPartsCounts) {
  const TempFolder folder;
  const std::string path = folder.Path("extent.exr");
  WriteForeignParts(path, {ForeignHeader(Box(0, 0, 9, 4), Box(0, 0, 9, 4), {"R", "G", "B"}),
                           ForeignHeader(Box(0, 0, 9, 4), Box(-2, -1, 12, 6), {"Z"})});
  Result<ExrExtent> extent = Measure(BytesOf(path));
  ASSERT_TRUE(extent.ok()) << extent.status().message();
  EXPECT_EQ(extent->width, 10);
  EXPECT_EQ(extent->height, 5);
  EXPECT_EQ(extent->pixels, 15 * 8);
  EXPECT_EQ(extent->channels, 4);

  WriteForeignScanlines(path, ForeignHeader(Box(0, 0, 9, 4), Box(3, 3, 4, 4), {"R", "G", "B"}));
  extent = Measure(BytesOf(path));
  ASSERT_TRUE(extent.ok());
  EXPECT_EQ(extent->pixels, 50);
  EXPECT_EQ(extent->channels, 3);
}

TEST(AovExtent, NeedsTheHeaderAndNothingElse) {
  const TempFolder folder;
  const std::string path = folder.Path("extent.exr");
  WriteForeignScanlines(path, ForeignHeader(Box(0, 0, 63, 63), Box(0, 0, 63, 63), {"Y"}));
  const std::string bytes = BytesOf(path);
  EXPECT_TRUE(Measure(bytes.substr(0, bytes.size() / 2)).ok());
  EXPECT_THAT(Measure(bytes.substr(0, 60)).status().message(),
              HasSubstr("f.exr: is a damaged EXR file"));
  EXPECT_EQ(Measure("not a picture").status().message(), "f.exr: is not an EXR file");
  EXPECT_EQ(Measure("").status().message(), "f.exr: is not an EXR file");
  EXPECT_THAT(Measure("\x89PNG\r\n").status().message(),
              ::testing::AllOf(::testing::HasSubstr("f.exr: is a PNG file, expected EXR"),
                               ::testing::HasSubstr("OpenEXR MultiLayer")));
}

}  // namespace
}  // namespace stillray::aov_extent_test
