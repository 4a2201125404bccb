// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <filesystem>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/sequence.h"
#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::sequence_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
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

constexpr std::string_view kExr[] = {".exr"};

std::vector<int64_t> FramesOf(const std::string& input) {
  const Result<std::vector<FrameFile>> files = FindFrameFiles(input, kExr);
  std::vector<int64_t> frames;
  if (!files.ok()) {
    ADD_FAILURE() << files.status().message();
    return frames;
  }
  for (const FrameFile& file : *files) {
    EXPECT_TRUE(std::filesystem::exists(file.path)) << file.path;
    frames.push_back(file.frame);
  }
  return frames;
}

std::string WhyNot(const std::string& input) {
  const Result<std::vector<FrameFile>> files = FindFrameFiles(input, kExr);
  EXPECT_FALSE(files.ok()) << input;
  return files.status().message();
}

TEST(FindFrameFiles, UnderstandsWhatUsersType) {
  const TempFolder folder;
  for (const char* name : {"shot.0001.exr", "shot.0002.exr", "shot.0010.exr", "shot.0003.png"}) {
    folder.Write(name, "x");
  }
  for (const char* name : {"shot.####.exr", "shot.%04d.exr", "shot.#.exr", "shot.##.exr",
                           "shot.%d.exr", "shot.*.exr", "shot.????.exr", "*.exr", "shot*", ""}) {
    EXPECT_THAT(FramesOf(folder.Path(name)), ElementsAre(1, 2, 10)) << name;
  }
}

TEST(FindFrameFiles, TheWidthOfThePatternGoesFirst) {
  const TempFolder folder;
  for (const char* name : {"a.01.exr", "a.0002.exr"}) {
    folder.Write(name, "x");
  }
  EXPECT_THAT(FramesOf(folder.Path("a.##.exr")), ElementsAre(1));
  EXPECT_THAT(FramesOf(folder.Path("a.####.exr")), ElementsAre(2));
  EXPECT_THAT(FramesOf(folder.Path("a.*.exr")), ElementsAre(1, 2));
}

TEST(FindFrameFiles, ErrorsSayWhatIsThere) {
  const TempFolder folder;
  for (const char* name : {"shot.0001.exr", "shot.0016.exr", "shot.0001.png"}) {
    folder.Write(name, "x");
  }
  EXPECT_THAT(WhyNot(folder.Path("shto.####.exr")),
              HasSubstr("no file matches this pattern; found shot.0001.exr ... shot.0016.exr: did "
                        "you mean " +
                        folder.Path("shot.####.exr")));
  EXPECT_THAT(WhyNot(folder.Path("shot.exr")), HasSubstr("no such file; found shot.0001.exr"));
  EXPECT_THAT(WhyNot(folder.Path("none/a.####.exr")), HasSubstr("cannot be listed"));
  folder.Write("a.1.exr", "x");
  EXPECT_THAT(WhyNot(folder.Path("*.exr")), HasSubstr("matches 2 sequences"));
  EXPECT_THAT(WhyNot(folder.Path("")), HasSubstr("holds 2 sequences"));
  EXPECT_THAT(WhyNot(folder.Path("sho.####.exr")), HasSubstr("did you mean"));
  folder.Write("a.0001.exr", "x");
  EXPECT_THAT(WhyNot(folder.Path("a.*.exr")),
              HasSubstr("a.0001.exr and a.1.exr are the same frame"));
  const TempFolder empty;
  EXPECT_THAT(WhyNot(empty.Path("a.####.exr")), HasSubstr("there are no numbered files of kind"));
}

TEST(AsFramePattern, TurnsWildCardsIntoMarks) {
  EXPECT_EQ(AsFramePattern("a*/s.*.exr"), "a*/s.####.exr");
  EXPECT_EQ(AsFramePattern("s.???.exr"), "s.###.exr");
  EXPECT_EQ(AsFramePattern("s.%04d.exr"), "s.%04d.exr");
  EXPECT_EQ(AsFramePattern("s.exr"), "s.exr");
}

}  // namespace
}  // namespace stillray::sequence_test
