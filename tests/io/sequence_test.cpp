// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(FrameFileName, PutsTheNumberIn) {
  EXPECT_EQ(FrameFileName("a.####.exr", 7), "a.0007.exr");
  EXPECT_EQ(FrameFileName("a.####.exr", 12345), "a.12345.exr");
  EXPECT_EQ(FrameFileName("a.####.exr", -7), "a.-0007.exr");
  EXPECT_EQ(FrameFileName("a#", 3), "a3");
  EXPECT_EQ(FrameFileName("dir/a.%04d.exr", 7), "dir/a.0007.exr");
  EXPECT_EQ(FrameFileName("a.%d.exr", 7), "a.7.exr");
  EXPECT_EQ(FrameFileName("a.%3d.exr", 7), "a.007.exr");
  EXPECT_EQ(FrameFileName("####", std::numeric_limits<int64_t>::min()), "-9223372036854775808");
}

TEST(FrameFileName, OnlyTheLastRunOfTheNameCounts) {
  EXPECT_EQ(FrameFileName("shot##_a.###.exr", 7), "shot##_a.007.exr");
  EXPECT_EQ(FrameFileName("dir##/a.exr", 7), "dir##/a.exr");
  EXPECT_EQ(FrameFileName("plain.exr", 7), "plain.exr");
  EXPECT_EQ(FrameFileName("100%.%02d.exr", 7), "100%.07.exr");
  EXPECT_EQ(FrameFileName("%s%x.exr", 7), "%s%x.exr");
}

TEST(FrameFileName, AbsurdWidthsAreBounded) {
  EXPECT_EQ(FrameFileName("%0999999999999d", 7).size(), 18u);
  EXPECT_EQ(FrameFileName(std::string(300, '#'), 7).size(), 18u);
}

TEST(IsFramePattern, LooksAtTheNameAlone) {
  EXPECT_TRUE(IsFramePattern("a.#.exr"));
  EXPECT_TRUE(IsFramePattern("a.%04d.exr"));
  EXPECT_FALSE(IsFramePattern("a.exr"));
  EXPECT_FALSE(IsFramePattern("dir.####/a.exr"));
  EXPECT_FALSE(IsFramePattern("a.%04f.exr"));
  EXPECT_FALSE(IsFramePattern("a.%"));
  EXPECT_FALSE(IsFramePattern(""));
}

TEST(FindFrames, FindsTheFilesOfThePatternSorted) {
  const TempFolder folder;
  for (const char* name :
       {"a.0010.exr", "a.0002.exr", "a.-0001.exr", "a.12345.exr", "a.002.exr", "a.00003.exr",
        "a.0004.png", "b.0005.exr", "a.00x6.exr", "a..exr", "a.+007.exr", "a.-0000.exr"}) {
    folder.Write(name, "x");
  }
  std::filesystem::create_directory(folder.Path("a.0008.exr"));
  EXPECT_THAT(FindFrames(folder.Path("a.####.exr")), ElementsAre(-1, 2, 10, 12345));
  EXPECT_THAT(FindFrames(folder.Path("a.%03d.exr")), ElementsAre(2, 12345));
  EXPECT_THAT(FindFrames(folder.Path("a.0002.exr")), IsEmpty());
  EXPECT_THAT(FindFrames(folder.Path("no/a.####.exr")), IsEmpty());
}

TEST(FindFrames, FindsWhatFrameFileNameMade) {
  const TempFolder folder;
  const std::string pattern = folder.Path("x#.%02d.y");
  for (const int64_t frame : {-120, 0, 9, 100}) {
    folder.Write(std::filesystem::path(FrameFileName(pattern, frame)).filename(), "x");
  }
  EXPECT_THAT(FindFrames(pattern), ElementsAre(-120, 0, 9, 100));
}

}  // namespace
}  // namespace stillray
