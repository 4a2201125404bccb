// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Standard output of a shell command.
std::string Output(const std::string& command) {
  std::string text;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) {
    return text;
  }
  std::array<char, 65536> buffer;
  while (const size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    text.append(buffer.data(), got);
  }
  ::pclose(pipe);
  return text;
}

#define SKIP_WITHOUT_FFMPEG()                                              \
  if (Output("ffmpeg -version 2>/dev/null").empty() ||                     \
      Output("ffprobe -version 2>/dev/null").empty()) {                    \
    GTEST_SKIP() << "ffmpeg and ffprobe are needed but are not installed"; \
  }

Rgb8Image Flat(int width, int height, uint8_t r, uint8_t g, uint8_t b) {
  Rgb8Image image{width, height, {}};
  for (int i = 0; i < width * height; ++i) {
    image.pixels.insert(image.pixels.end(), {r, g, b});
  }
  return image;
}

/// PATH with only one folder while it lives.
class PathOverride {
 public:
  explicit PathOverride(const std::string& folder) : old_(std::getenv("PATH")) {
    ::setenv("PATH", folder.c_str(), 1);
  }
  ~PathOverride() { ::setenv("PATH", old_.c_str(), 1); }

 private:
  std::string old_;
};

/// A program named ffmpeg in the folder `bin`.
std::string FakeFfmpeg(const TempFolder& folder, const std::string& script) {
  std::filesystem::create_directory(folder.Path("bin"));
  const std::string path = folder.Write("bin/ffmpeg", "#!/bin/sh\n" + script);
  ::chmod(path.c_str(), 0755);
  return folder.Path("bin");
}

Status WriteVideo(const std::string& path, int frames, const Rgb8Image& frame) {
  Result<std::unique_ptr<VideoWriter>> writer =
      VideoWriter::Create(path, frame.width, frame.height, 25);
  if (!writer.ok()) {
    return writer.status();
  }
  for (int i = 0; i < frames; ++i) {
    STILLRAY_RETURN_IF_ERROR((*writer)->Write(frame));
  }
  return (*writer)->Finish();
}

TEST(Video, HasTheRightSizeRateAndTags) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  const std::string path = folder.Path("a clip: 100%.mp4");
  const Status status = WriteVideo(path, 10, Flat(64, 48, 200, 50, 30));
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(folder.List(), ElementsAre("a clip: 100%.mp4"));
  const std::string facts = Output(fmt::format(
      "ffprobe -v error -count_frames -show_entries stream=codec_name,width,height,pix_fmt,"
      "color_range,color_space,color_transfer,color_primaries,r_frame_rate,nb_read_frames "
      "-of default=nw=1 'file:{}'",
      path));
  EXPECT_THAT(facts, AllOf(HasSubstr("codec_name=h264"), HasSubstr("width=64\n"),
                           HasSubstr("height=48\n"), HasSubstr("pix_fmt=yuv420p"),
                           HasSubstr("color_range=tv"), HasSubstr("color_space=bt709"),
                           HasSubstr("color_transfer=bt709"), HasSubstr("color_primaries=bt709"),
                           HasSubstr("r_frame_rate=25/1"), HasSubstr("nb_read_frames=10")));
  const std::string bytes = FileBytes(path);
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat")) << "the index is not at the front";
}

TEST(Video, KeepsColours) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  const std::string path = folder.Path("a.mp4");
  const Status status = WriteVideo(path, 3, Flat(64, 48, 200, 50, 30));
  ASSERT_TRUE(status.ok()) << status.message();
  const std::string pixels = Output(fmt::format(
      "ffmpeg -v error -i '{}' -vf scale=in_color_matrix=bt709:in_range=tv:flags=accurate_rnd -f "
      "rawvideo -pix_fmt rgb24 -",
      path));
  ASSERT_EQ(pixels.size(), 3u * 64 * 48 * 3);
  const int expected[] = {200, 50, 30};
  for (size_t i = 0; i < pixels.size(); ++i) {
    ASSERT_NEAR(static_cast<uint8_t>(pixels[i]), expected[i % 3], 3) << i;
  }
}

TEST(Video, PadsOddSizes) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  const std::string path = folder.Path("a.mp4");
  const Status status = WriteVideo(path, 2, Flat(33, 17, 90, 90, 90));
  ASSERT_TRUE(status.ok()) << status.message();
  const std::string pixels =
      Output(fmt::format("ffmpeg -v error -i '{}' -f rawvideo -pix_fmt gray -", path));
  ASSERT_EQ(pixels.size(), 2u * 34 * 18);
  for (const char pixel : pixels) {
    ASSERT_NEAR(static_cast<uint8_t>(pixel), 90, 4);  // no black edge
  }
}

TEST(Video, SameFramesGiveTheSameBytes) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  for (const char* name : {"a.mp4", "b.mp4"}) {
    ASSERT_TRUE(WriteVideo(folder.Path(name), 30, Flat(64, 48, 1, 2, 3)).ok());
  }
  EXPECT_EQ(FileBytes(folder.Path("a.mp4")), FileBytes(folder.Path("b.mp4")));
}

TEST(Video, UnfinishedVideoLeavesNothing) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  {
    auto writer = VideoWriter::Create(folder.Path("a.mp4"), 64, 48, 25);
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE((*writer)->Write(Flat(64, 48, 1, 2, 3)).ok());
  }
  EXPECT_THAT(folder.List(), IsEmpty());
  EXPECT_EQ(WriteVideo(folder.Path("a.mp4"), 0, Flat(64, 48, 1, 2, 3)).code(),
            StatusCode::kInvalidArgument);
  EXPECT_THAT(folder.List(), IsEmpty());
}

TEST(Video, WrongFramesAreRefusedAndDoNoHarm) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  auto writer = VideoWriter::Create(folder.Path("a.mp4"), 64, 48, 25);
  ASSERT_TRUE(writer.ok());
  EXPECT_THAT((*writer)->Write(Flat(64, 47, 1, 2, 3)).message(), HasSubstr("64 x 47"));
  EXPECT_TRUE((*writer)->Write(Flat(64, 48, 1, 2, 3)).ok());
  EXPECT_TRUE((*writer)->Finish().ok());
  EXPECT_TRUE((*writer)->Finish().ok());
  EXPECT_EQ((*writer)->Write(Flat(64, 48, 1, 2, 3)).code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(folder.List(), ElementsAre("a.mp4"));
}

TEST(Video, MissingFfmpegIsNamed) {
  const TempFolder folder;
  const PathOverride path(folder.Path(""));
  const Status status = WriteVideo(folder.Path("a.mp4"), 1, Flat(8, 8, 1, 2, 3));
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_THAT(status.message(), HasSubstr("install the package ffmpeg"));
  EXPECT_THAT(folder.List(), IsEmpty());
}

TEST(Video, FailureIsReportedInFfmpegsOwnWords) {
  const TempFolder folder;
  const PathOverride path(
      FakeFfmpeg(folder, "echo first line >&2\necho \"Unknown encoder 'libx264'\" >&2\nexit 1\n"));
  // Large enough to fill every buffer, so that a write fails at the closed end.
  const Status status = WriteVideo(folder.Path("a.mp4"), 20, Flat(512, 512, 1, 2, 3));
  EXPECT_EQ(status.code(), StatusCode::kIo);
  EXPECT_THAT(status.message(), AllOf(HasSubstr("a.mp4"), HasSubstr("Unknown encoder 'libx264'")));
  EXPECT_THAT(folder.List(), ElementsAre("bin"));
}

// ffmpeg gives the cause some lines before its last one.
TEST(Video, AFullDiskIsNamed) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  Rgb8Image noise = Flat(256, 256, 0, 0, 0);
  uint32_t seed = 1;
  for (uint8_t& byte : noise.pixels) {
    seed = seed * 1664525u + 1013904223u;
    byte = static_cast<uint8_t>(seed >> 24);
  }
  const FileSizeLimit limit(20000);
  const Status status = WriteVideo(folder.Path("a.mp4"), 60, noise);
  EXPECT_EQ(status.code(), StatusCode::kIo);
  EXPECT_THAT(status.message(), AllOf(HasSubstr("a.mp4"), HasSubstr("File too large")));
  EXPECT_THAT(folder.List(), IsEmpty());
}

TEST(Video, TheCauseIsFoundAmongTheLastLines) {
  const TempFolder folder;
  const PathOverride path(
      FakeFfmpeg(folder,
                 "echo 'av_interleaved_write_frame(): No space left on device' >&2\n"
                 "echo 'Error initializing output stream 0:0 -- ' >&2\nexit 1\n"));
  EXPECT_THAT(WriteVideo(folder.Path("a.mp4"), 20, Flat(512, 512, 1, 2, 3)).message(),
              HasSubstr("failed to write the video: No space left on device"));
}

// Users with write access to the folder can replace the file with a link: ffmpeg must not follow
// it.
TEST(Video, IsNotWrittenThroughALink) {
  SKIP_WITHOUT_FFMPEG();
  const TempFolder folder;
  const std::string victim = folder.Write("victim", "keep me");
  auto writer = VideoWriter::Create(folder.Path("a.mp4"), 64, 48, 25);
  ASSERT_TRUE(writer.ok());
  for (const std::string& name : folder.List()) {
    if (name.rfind(".a.mp4.tmp-", 0) == 0) {
      std::filesystem::remove(folder.Path(name));
      std::filesystem::create_symlink(victim, folder.Path(name));
    }
  }
  ASSERT_TRUE((*writer)->Write(Flat(64, 48, 1, 2, 3)).ok());
  static_cast<void>((*writer)->Finish());
  EXPECT_EQ(FileBytes(victim), "keep me");
}

TEST(Video, FailureAtTheEndIsReported) {
  const TempFolder folder;
  const PathOverride path(FakeFfmpeg(folder, "while read -r line; do :; done\nexit 7\n"));
  const Status status = WriteVideo(folder.Path("a.mp4"), 1, Flat(8, 8, 1, 2, 3));
  EXPECT_EQ(status.code(), StatusCode::kIo);
  EXPECT_THAT(status.message(), HasSubstr("code 7"));
}

TEST(Video, SilentFailureIsReported) {
  const TempFolder folder;
  const PathOverride path(FakeFfmpeg(folder, "exit 0\n"));
  EXPECT_THAT(WriteVideo(folder.Path("a.mp4"), 1, Flat(8, 8, 1, 2, 3)).code(), StatusCode::kIo);
}

TEST(Video, ManyMessagesCannotBlock) {
  const TempFolder folder;
  const PathOverride path(FakeFfmpeg(
      folder,
      "i=0\nwhile [ $i -lt 5000 ]; do echo a rather long line of complaint number $i >&2; "
      "i=$((i+1)); done\nexit 1\n"));
  const Status status = WriteVideo(folder.Path("a.mp4"), 20, Flat(512, 512, 1, 2, 3));
  EXPECT_THAT(status.message(), HasSubstr("number 4999"));
}

TEST(Video, BadArgumentsAreRefused) {
  const TempFolder folder;
  const auto code = [&](const std::string& name, int width, int height, double fps) {
    return VideoWriter::Create(folder.Path(name), width, height, fps).status().code();
  };
  EXPECT_EQ(code("a.mp4", 0, 8, 25), StatusCode::kInvalidArgument);
  EXPECT_EQ(code("a.mp4", 8, 20000, 25), StatusCode::kInvalidArgument);
  EXPECT_EQ(code("a.mp4", 8, 8, 0), StatusCode::kInvalidArgument);
  EXPECT_EQ(code("a.mp4", 8, 8, std::nan("")), StatusCode::kInvalidArgument);
  EXPECT_EQ(code("no/a.mp4", 8, 8, 25), StatusCode::kNotFound);
  EXPECT_EQ(VideoWriter::Create("/dev/null", 8, 8, 25).status().code(), StatusCode::kUnsupported);
}

}  // namespace
}  // namespace stillray
