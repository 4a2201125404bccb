// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The library behind `stillray denoise`, without the program: its calls, its end, its state.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/cli_denoise_shot.h"
#include "io/test_files.h"
#include "stillray/sequence.h"

namespace stillray::sequence_denoiser_test {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SequenceDenoisers : public ::testing::TestWithParam<Window> {
 protected:
  SequenceOptions Options(int64_t frames, const std::string& out) {
    WriteShot(folder_.Path("in.####.exr"), Shot(), 1, frames);
    fs::create_directories(folder_.Path(out));
    SequenceOptions options;
    for (int64_t frame = 1; frame <= frames; ++frame) {
      options.files.push_back({frame, FrameFileName(folder_.Path("in.####.exr"), frame),
                               FrameFileName(folder_.Path(out) + "/f.####.exr", frame)});
    }
    options.settings = PresetSettings("default").value();
    options.window = GetParam();
    return options;
  }

  /// Runs to the end, with everything as it should be.
  void Denoise(const SequenceOptions& options, const SequenceHooks& hooks = {}) {
    Result<SequenceDenoiser> run = SequenceDenoiser::Create(options, Device(), hooks);
    ASSERT_TRUE(run.ok()) << run.status().message();
    const SequenceEnd end = run->Run();
    ASSERT_TRUE(end.status.ok()) << end.status.message();
    EXPECT_FALSE(end.can_resume);
    EXPECT_EQ(run->finished(), options.files.size());
    EXPECT_EQ(run->reports().size(), options.files.size());
  }

  void ExpectSameFiles(const SequenceOptions& a, const SequenceOptions& b) {
    for (size_t i = 0; i < a.files.size(); ++i) {
      EXPECT_TRUE(FileBytes(a.files[i].output) == FileBytes(b.files[i].output)) << i;
      EXPECT_FALSE(FileBytes(a.files[i].output).empty());
    }
  }

  TempFolder folder_;
};

TEST_P(SequenceDenoisers, OverlapChangesNoBits) {
  const SequenceOptions overlapped = Options(20, "a");
  SequenceOptions plain = Options(20, "b");
  plain.overlap = false;
  Denoise(overlapped);
  Denoise(plain);
  ExpectSameFiles(overlapped, plain);
}

// Enough for one future beside the rest, and for no overlap.
TEST_P(SequenceDenoisers, AMemoryLimitChangesNoBits) {
  const SequenceOptions free = Options(20, "a");
  Denoise(free);
  SequenceOptions narrow = Options(20, "b");
  narrow.memory = {1, "the test allows"};
  const Result<SequenceDenoiser> refused = SequenceDenoiser::Create(narrow, Device(), {});
  EXPECT_EQ(refused.status().code(), StatusCode::kOutOfMemory);
  const std::string& message = refused.status().message();
  EXPECT_THAT(message, HasSubstr("the test allows 0.0 MB"));
  const std::string marker = "takes about ";
  const double megabytes = std::stod(message.substr(message.find(marker) + marker.size()));
  narrow.memory.bytes = static_cast<int64_t>((megabytes + 0.1) * 1e6);
  std::vector<std::string> notes;
  SequenceHooks hooks;
  hooks.note = [&](const std::string& text) { notes.push_back(text); };
  Denoise(narrow, hooks);
  EXPECT_THAT(notes, Contains(HasSubstr("files are not read and written beside the filter")));
  ExpectSameFiles(free, narrow);
}

TEST_P(SequenceDenoisers, CallsItsOwnerForEveryFrame) {
  const SequenceOptions options = Options(5, "a");
  std::vector<int64_t> finished;
  std::vector<int64_t> pictures;
  size_t ahead = 0;
  SequenceHooks hooks;
  hooks.finished = [&](const FrameReport& report) {
    finished.push_back(report.frame);
    EXPECT_EQ(report.written_bytes, static_cast<int64_t>(fs::file_size(report.output)));
    EXPECT_GT(report.denoise_ms, 0);
    EXPECT_FALSE(report.stages.empty());
  };
  hooks.picture = [&](const SequenceFile& file, const Image3& colour) {
    pictures.push_back(file.frame);
    EXPECT_EQ(colour.width(), Shot::kWidth);
    EXPECT_FALSE(fs::exists(file.output)) << "a frame is complete once its file is there";
    return Status::Ok();
  };
  hooks.looks_ahead = [&](const SequenceFile&) { ++ahead; };
  Result<SequenceDenoiser> run = SequenceDenoiser::Create(options, Device(), hooks);
  ASSERT_TRUE(run.ok()) << run.status().message();
  const size_t steps = run->look_ahead_steps();
  EXPECT_EQ(steps, GetParam() == Window::kBoth ? 5u : 0u);
  EXPECT_TRUE(run->Run().status.ok());
  EXPECT_THAT(finished, ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(pictures, finished);
  EXPECT_EQ(ahead, steps);
  EXPECT_TRUE(run->motion_was_seen());
  EXPECT_GT(run->memory_bytes(), 0u);
}

TEST_P(SequenceDenoisers, AnErrorOfTheOwnerStopsTheRun) {
  const SequenceOptions options = Options(5, "a");
  SequenceHooks hooks;
  hooks.picture = [&](const SequenceFile& file, const Image3&) {
    return file.frame == 3 ? Status::Io("no room") : Status::Ok();
  };
  Result<SequenceDenoiser> run = SequenceDenoiser::Create(options, Device(), hooks);
  ASSERT_TRUE(run.ok());
  const SequenceEnd end = run->Run();
  EXPECT_EQ(end.status.message(), "no room");
  EXPECT_FALSE(end.can_resume) << "no state was asked for";
  EXPECT_EQ(run->finished(), 2u);
  EXPECT_FALSE(fs::exists(options.files[2].output));
}

// At every frame, and during accumulation of the future: the result is the same.
TEST_P(SequenceDenoisers, ARunThatIsStoppedGoesOnWithTheSameBits) {
  const SequenceOptions whole = Options(6, "whole");
  Denoise(whole);
  for (int polls = 0; polls < 14; ++polls) {
    SequenceOptions part = Options(6, "part" + std::to_string(polls));
    part.state.keep = true;
    int left = polls;
    SequenceHooks hooks;
    hooks.keep_going = [&] { return left-- > 0; };
    Result<SequenceDenoiser> first = SequenceDenoiser::Create(part, Device(), hooks);
    ASSERT_TRUE(first.ok());
    const SequenceEnd end = first->Run();
    EXPECT_EQ(end.can_resume, end.status.code() == StatusCode::kCancelled && first->finished() > 0);
    part.state.resume = true;
    hooks = SequenceHooks();
    Result<SequenceDenoiser> second = SequenceDenoiser::Create(part, Device(), hooks);
    ASSERT_TRUE(second.ok()) << second.status().message();
    EXPECT_EQ(second->resumed(), end.can_resume);
    EXPECT_EQ(second->finished(), end.can_resume ? end.resumes_at : 0);
    EXPECT_TRUE(second->Run().status.ok());
    ExpectSameFiles(whole, part);
    second->RemoveState();
    EXPECT_FALSE(fs::exists(folder_.Path("part" + std::to_string(polls)) + "/resume.stillray"));
  }
}

// Frames are filtered ahead of the one that fails: their pictures are in the state.
TEST_P(SequenceDenoisers, APictureThatCannotBeWrittenIsNotFilteredAgain) {
  const SequenceOptions whole = Options(5, "whole");
  Denoise(whole);
  for (const bool overlap : {false, true}) {
    SequenceOptions part = Options(5, overlap ? "overlapped" : "plain");
    part.overlap = overlap;
    part.state.keep = true;
    fs::create_directories(part.files[1].output + "/in_the_way");
    Result<SequenceDenoiser> first = SequenceDenoiser::Create(part, Device(), {});
    ASSERT_TRUE(first.ok());
    const SequenceEnd end = first->Run();
    EXPECT_THAT(end.status.message(), HasSubstr("f.0002.exr: could not be written"));
    ASSERT_TRUE(end.can_resume);
    EXPECT_EQ(end.resumes_at, 1u);
    fs::remove_all(part.files[1].output);
    part.state.resume = true;
    std::vector<bool> filtered;
    SequenceHooks hooks;
    hooks.finished = [&](const FrameReport& report) { filtered.push_back(report.denoise_ms > 0); };
    Result<SequenceDenoiser> second = SequenceDenoiser::Create(part, Device(), hooks);
    ASSERT_TRUE(second.ok()) << second.status().message();
    EXPECT_TRUE(second->Run().status.ok());
    EXPECT_THAT(filtered, overlap ? ElementsAre(false, false, true, true)
                                  : ElementsAre(false, true, true, true));
    ExpectSameFiles(whole, part);
  }
}

// A second failure at another frame, with pictures of the first run still in the state.
TEST_P(SequenceDenoisers, PicturesOfAnEarlierRunStayInTheStateUntilTheyAreWritten) {
  const SequenceOptions whole = Options(5, "whole");
  Denoise(whole);
  SequenceOptions part = Options(5, "part");
  part.state.keep = true;
  for (const size_t blocked : {1, 2}) {
    fs::create_directories(part.files[blocked].output + "/in_the_way");
    Result<SequenceDenoiser> run = SequenceDenoiser::Create(part, Device(), {});
    ASSERT_TRUE(run.ok()) << run.status().message();
    const SequenceEnd end = run->Run();
    ASSERT_TRUE(end.can_resume);
    EXPECT_EQ(end.resumes_at, blocked);
    fs::remove_all(part.files[blocked].output);
    part.state.resume = true;
  }
  Result<SequenceDenoiser> last = SequenceDenoiser::Create(part, Device(), {});
  ASSERT_TRUE(last.ok()) << last.status().message();
  EXPECT_TRUE(last->Run().status.ok());
  ExpectSameFiles(whole, part);
}

TEST_P(SequenceDenoisers, AStateOfOtherOptionsIsRefused) {
  SequenceOptions options = Options(3, "a");
  options.state.keep = true;
  options.state.fingerprint = "colour red\n";
  fs::create_directories(options.files[2].output + "/in_the_way");
  Result<SequenceDenoiser> first = SequenceDenoiser::Create(options, Device(), {});
  ASSERT_TRUE(first.ok());
  EXPECT_TRUE(first->Run().can_resume);
  options.state.resume = true;
  const auto error = [&](const SequenceOptions& changed) {
    return SequenceDenoiser::Create(changed, Device(), {}).status().message();
  };
  SequenceOptions other = options;
  other.state.fingerprint = "colour blue\n";
  EXPECT_THAT(error(other), HasSubstr("made with 'colour red', this run has 'colour blue'"));
  other = options;
  ASSERT_TRUE(SetParameter(&other.settings, "alpha_min", "0.2").ok());
  EXPECT_THAT(error(other), HasSubstr("made with 'alpha_min 0.1', this run has"));
  other = options;
  other.window = GetParam() == Window::kBoth ? Window::kPast : Window::kBoth;
  EXPECT_THAT(error(other), HasSubstr("made with 'window "));
  // The window of a run that is resumed is its own, where the user leaves the choice.
  other.window_may_narrow = true;
  const Result<SequenceDenoiser> same = SequenceDenoiser::Create(other, Device(), {});
  ASSERT_TRUE(same.ok()) << same.status().message();
  EXPECT_EQ(same->options().window, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Windows, SequenceDenoisers,
                         ::testing::Values(Window::kPast, Window::kBoth),
                         [](const auto& info) { return std::string(WindowName(info.param)); });

TEST(SequenceDenoiser, NoDeviceIsOpenedForAFileThatCannotBeRead) {
  SequenceOptions options;
  options.files.push_back({1, "/nonexistent/in.exr", "/nonexistent/out.exr"});
  options.settings = PresetSettings("default").value();
  bool opened = false;
  const SequenceDenoiser::OpenDevice open = [&]() -> Result<Device> {
    opened = true;
    return Device();
  };
  EXPECT_EQ(SequenceDenoiser::Create(options, open, {}).status().code(), StatusCode::kNotFound);
  EXPECT_FALSE(opened);
}

TEST(SequenceDenoiser, FilesInDisorderAreRefused) {
  const auto error = [](std::vector<SequenceFile> files) {
    SequenceOptions options;
    options.files = std::move(files);
    const Status status = SequenceDenoiser::Create(options, Device()).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message();
  };
  EXPECT_THAT(error({}), HasSubstr("no files"));
  EXPECT_THAT(error({{2, "a", "b/c"}, {2, "d", "b/e"}}), HasSubstr("frame 2 comes after frame 2"));
  EXPECT_THAT(error({{1, "a", "b/c"}, {2, "d", "e/f"}}),
              HasSubstr("b/c and e/f lie in two folders"));
}

}  // namespace
}  // namespace stillray::sequence_denoiser_test
