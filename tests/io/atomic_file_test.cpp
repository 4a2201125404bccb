// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <sys/stat.h>

#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::atomic_file_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Status Write(const std::string& path, const std::string& bytes) {
  return WriteFileAtomically(path, bytes.data(), bytes.size());
}

TEST(AtomicFile, WritesAndReplaces) {
  const TempFolder folder;
  const std::string path = folder.Path("a.bin");
  ASSERT_TRUE(Write(path, std::string("one\0two", 7)).ok());
  EXPECT_EQ(FileBytes(path), std::string("one\0two", 7));
  ASSERT_TRUE(Write(path, "").ok());
  EXPECT_EQ(FileBytes(path), "");
  EXPECT_THAT(folder.List(), ElementsAre("a.bin"));
}

TEST(AtomicFile, RespectsTheUmask) {
  const TempFolder folder;
  const mode_t old = ::umask(027);
  const Status status = Write(folder.Path("a"), "x");
  ::umask(old);
  ASSERT_TRUE(status.ok()) << status.message();
  struct stat info {};
  ASSERT_EQ(::stat(folder.Path("a").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0640u);
}

TEST(AtomicFile, KeepsTheRightsOfTheFileThatItReplaces) {
  const TempFolder folder;
  const std::string path = folder.Path("a");
  for (const mode_t mode : {0600, 0640, 0664, 0444}) {
    ASSERT_TRUE(Write(path, "old").ok());
    ASSERT_EQ(::chmod(path.c_str(), mode), 0);
    ASSERT_TRUE(Write(path, "new").ok());
    struct stat info {};
    ASSERT_EQ(::stat(path.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, mode);
    EXPECT_EQ(FileBytes(path), "new");
  }
}

TEST(AtomicFile, FailedWriteKeepsTheOldFileAndLeavesNoTrace) {
  const TempFolder folder;
  const std::string path = folder.Write("a.bin", "old");
  Status status;
  {
    const FileSizeLimit limit(1000);
    status = Write(path, std::string(5000, 'x'));
  }
  EXPECT_EQ(status.code(), StatusCode::kIo);
  EXPECT_THAT(status.message(), HasSubstr(path));
  EXPECT_THAT(status.message(), HasSubstr("File too large"));
  EXPECT_EQ(FileBytes(path), "old");
  EXPECT_THAT(folder.List(), ElementsAre("a.bin"));
}

TEST(AtomicFile, FailedWriteOfANewFileLeavesNothing) {
  const TempFolder folder;
  {
    const FileSizeLimit limit(1000);
    EXPECT_EQ(Write(folder.Path("a.bin"), std::string(5000, 'x')).code(), StatusCode::kIo);
  }
  EXPECT_THAT(folder.List(), IsEmpty());
}

TEST(AtomicFile, ReportsAFullDevice) {
  const Status status = Write("/dev/full", "x");
  EXPECT_EQ(status.code(), StatusCode::kIo);
  EXPECT_THAT(status.message(), HasSubstr("No space left on device"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(AtomicFile, WritesDevicesDirectly) {
  EXPECT_TRUE(Write("/dev/null", "x").ok());
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(AtomicFile, NamesAMissingFolder) {
  const TempFolder folder;
  const Status status = Write(folder.Path("no/such/a.bin"), "x");
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr(folder.Path("no/such")));
}

TEST(AtomicFile, RefusesFoldersAndEmptyNames) {
  const TempFolder folder;
  std::filesystem::create_directory(folder.Path("sub"));
  EXPECT_EQ(Write(folder.Path("sub"), "x").code(), StatusCode::kIo);
  EXPECT_EQ(Write(folder.Path("sub/"), "x").code(), StatusCode::kIo);
  EXPECT_EQ(Write("", "x").code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(folder.List(), ElementsAre("sub"));
}

TEST(AtomicFile, FileInPlaceOfAFolderIsNotAFolder) {
  const TempFolder folder;
  const std::string file = folder.Write("file", "x");
  EXPECT_EQ(Write(file + "/a.bin", "x").code(), StatusCode::kNotFound);
}

TEST(AtomicFile, FollowsSymbolicLinks) {
  const TempFolder folder;
  folder.Write("target", "old");
  std::filesystem::create_symlink("target", folder.Path("link"));
  ASSERT_TRUE(Write(folder.Path("link"), "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder.Path("link")));
  EXPECT_EQ(FileBytes(folder.Path("target")), "new");
}

TEST(AtomicFile, WritesThroughADanglingLink) {
  const TempFolder folder;
  std::filesystem::create_symlink("target", folder.Path("link"));
  ASSERT_TRUE(Write(folder.Path("link"), "new").ok());
  EXPECT_EQ(FileBytes(folder.Path("target")), "new");
}

TEST(AtomicFile, CircleOfLinksIsAnError) {
  const TempFolder folder;
  std::filesystem::create_symlink("b", folder.Path("a"));
  std::filesystem::create_symlink("a", folder.Path("b"));
  EXPECT_EQ(Write(folder.Path("a"), "x").code(), StatusCode::kIo);
}

TEST(AtomicFile, AcceptsTheLongestName) {
  const TempFolder folder;
  const std::string path = folder.Path(std::string(255, 'n'));
  const Status status = Write(path, "x");
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(FileBytes(path), "x");
  EXPECT_EQ(Write(folder.Path(std::string(256, 'n')), "x").code(), StatusCode::kIo);
  EXPECT_EQ(folder.List().size(), 1u);
}

TEST(AtomicFile, ReadersNeverSeeAPart) {
  const TempFolder folder;
  const std::string path = folder.Write("a.bin", std::string(200000, 'a'));
  std::thread writer([&] {
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE(Write(path, std::string(200000, i % 2 == 0 ? 'b' : 'a')).ok());
    }
  });
  for (int i = 0; i < 100; ++i) {
    const std::string bytes = FileBytes(path);
    ASSERT_EQ(bytes.size(), 200000u);
    ASSERT_EQ(bytes, std::string(200000, bytes[0]));
  }
  writer.join();
}

TEST(AtomicFile, ADurableFileIsTheSame) {
  const TempFolder folder;
  const std::string path = folder.Path("a.bin");
  for (const char* bytes : {"one", "two"}) {
    ASSERT_TRUE(io::WriteFileDurably(path, bytes, 3).ok());
    EXPECT_EQ(FileBytes(path), bytes);
  }
  EXPECT_THAT(folder.List(), ElementsAre("a.bin"));
  EXPECT_TRUE(io::SyncFiles(std::vector<std::string>{path}).ok());
  const Status missing = io::SyncFiles(std::vector<std::string>{folder.Path("none")});
  EXPECT_EQ(missing.code(), StatusCode::kIo);
  EXPECT_THAT(missing.message(), HasSubstr(folder.Path("none")));
}

// Two containers may run processes of the same number.
TEST(AtomicFile, TemporaryNamesDoNotComeTwice) {
  const TempFolder folder;
  const Result<io::AtomicTarget> a = io::PrepareAtomicTarget(folder.Path("x"));
  const Result<io::AtomicTarget> b = io::PrepareAtomicTarget(folder.Path("x"));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NE(a->temp_path, b->temp_path);
  const Result<io::FileDescriptor> first = io::OpenTemporary(*a, "x");
  ASSERT_TRUE(first.ok());
  // Neither a file nor a link that somebody else has put there is used.
  EXPECT_EQ(io::OpenTemporary(*a, "x").status().code(), StatusCode::kIo);
  std::filesystem::create_symlink("target", b->temp_path);
  EXPECT_EQ(io::OpenTemporary(*b, "x").status().code(), StatusCode::kIo);
}

TEST(AtomicFile, OnlyTemporariesOfTheDeadAreRemoved) {
  const TempFolder folder;
  const Result<io::AtomicTarget> living = io::PrepareAtomicTarget(folder.Path("living.exr"));
  const Result<io::AtomicTarget> dead = io::PrepareAtomicTarget(folder.Path("dead.mp4"));
  ASSERT_TRUE(living.ok() && dead.ok());
  const Result<io::FileDescriptor> open = io::OpenTemporary(*living, "living.exr");
  ASSERT_TRUE(open.ok());
  ASSERT_TRUE(io::OpenTemporary(*dead, "dead.mp4").ok());  // closed at once, as by a kill
  folder.Write(".mine.tmp-123", "x");
  folder.Write(".notes.tmp-0123456789abcdeg", "x");
  folder.Write("frame.exr", "x");
  std::filesystem::create_symlink("frame.exr", folder.Path(".link.tmp-0123456789abcdef"));
  io::RemoveStaleTemporaries(folder.Path(""));
  EXPECT_FALSE(std::filesystem::exists(dead->temp_path));
  EXPECT_TRUE(std::filesystem::exists(living->temp_path));
  EXPECT_EQ(folder.List().size(), 5u);
}

TEST(ReadWholeFile, ReadsExactly) {
  const TempFolder folder;
  for (const size_t size : {size_t{0}, size_t{1}, size_t{65536}, size_t{65537}, size_t{300001}}) {
    std::string bytes(size, '\0');
    for (size_t i = 0; i < size; ++i) {
      bytes[i] = static_cast<char>(i * 31);
    }
    const Result<std::string> read = ReadWholeFile(folder.Write("a", bytes), size);
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_EQ(*read, bytes);
  }
}

TEST(ReadWholeFile, ReadsWhatHasNoSize) {
  const Result<std::string> read = ReadWholeFile("/proc/self/status", 1 << 20);
  ASSERT_TRUE(read.ok());
  EXPECT_THAT(*read, HasSubstr("Name:"));
}

TEST(ReadWholeFile, RefusesWhatIsTooLarge) {
  const TempFolder folder;
  const std::string path = folder.Write("a", "12345");
  const Result<std::string> read = ReadWholeFile(path, 4);
  EXPECT_EQ(read.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(read.status().message(), HasSubstr(path));
}

// A pipe could block for ever, a device never end.
TEST(ReadWholeFile, RefusesWhatIsNoOrdinaryFile) {
  const TempFolder folder;
  const std::string pipe = folder.Path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& path : {pipe, std::string("/dev/zero"), std::string("/dev/null")}) {
    const Result<std::string> read = ReadWholeFile(path, 1 << 20);
    EXPECT_EQ(read.status().code(), StatusCode::kIo);
    EXPECT_EQ(read.status().message(), path + ": is not an ordinary file");
  }
}

TEST(ReadWholeFile, NamesWhatIsMissing) {
  const TempFolder folder;
  const Result<std::string> read = ReadWholeFile(folder.Path("none"), 10);
  EXPECT_EQ(read.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(read.status().message(), HasSubstr(folder.Path("none")));
  EXPECT_EQ(ReadWholeFile(folder.Path(""), 10).status().code(), StatusCode::kIo);
}

}  // namespace
}  // namespace stillray::atomic_file_test
